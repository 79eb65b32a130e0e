// SPDX-License-Identifier: MIT
//
// A large scene made of copies of a small one, to measure cost against scene size.
#pragma once

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// copies.x * copies.y copies on a grid along the two axes most perpendicular to `up`, at distances
/// of 1.1 times the core box. The first copy keeps its positions and indices. Throws Error(device)
/// for more than 2^31 - 1 Gaussians.
GaussianCloud replicate(const GaussianCloud& cloud, glm::ivec2 copies, glm::dvec3 up);

}  // namespace qs
