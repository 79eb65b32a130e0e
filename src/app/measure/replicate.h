// SPDX-License-Identifier: MIT
//
// A larger scene made of copies of a small one, to measure cost against scene size.
#pragma once

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Copies on a grid along the two axes that are most level (`up` is the world's up), one core box
/// and a tenth apart. The first copy stays where the scene is and keeps its indices. Throws
/// Error(device) for more Gaussians than an index counts.
GaussianCloud replicate(const GaussianCloud& cloud, glm::ivec2 copies, glm::dvec3 up);

}  // namespace qs
