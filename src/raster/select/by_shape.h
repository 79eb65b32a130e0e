// SPDX-License-Identifier: MIT
//
// Selects the Gaussians that a shape in a picture meets.
#pragma once

#include <memory>

#include "raster/api/renderer.h"
#include "raster/scene/gaussian_set.h"
#include "raster/select/shape.h"

namespace qs {

/// The Gaussians with a centre in front of the near plane and inside of the shape, also hidden
/// ones. In double precision without contraction, so every machine selects the same.
GaussianSet gaussians_through(const GaussianCloud& cloud, const Camera& camera, const Shape& shape,
                              ThreadPool& pool);

/// The pixels of a picture of `size` with their centres in the shape, for Outputs::seen.
std::shared_ptr<const SeenPixels> pixels_in(const Shape& shape, glm::ivec2 size, float weight,
                                            ThreadPool& pool);

}  // namespace qs
