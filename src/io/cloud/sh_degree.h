// SPDX-License-Identifier: MIT
//
// Reduces the SH degree: less memory and faster rendering, with less view dependence.
#pragma once

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// The cloud with SH up to `degree` (0..3); unchanged if its degree is not higher.
GaussianCloud with_sh_degree(GaussianCloud cloud, int degree);

}  // namespace qs
