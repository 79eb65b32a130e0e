// SPDX-License-Identifier: MIT
//
// Selects the Gaussians that a shape in a picture meets.
#pragma once

#include "raster/api/renderer.h"
#include "raster/scene/gaussian_set.h"
#include "raster/select/shape.h"

namespace qs {

/// The Gaussians with a centre in front of the near plane and inside of the shape, also hidden
/// ones. In double precision without contraction, so every machine selects the same.
GaussianSet gaussians_through(const GaussianCloud& cloud, const Camera& camera, const Shape& shape,
                              ThreadPool& pool);

/// The Gaussians that a pixel with its centre in the shape blends with at least this weight: alpha
/// times the transmittance in front. 0: all that a pixel blends. `frame` has a trace, and `size` is
/// its image's. Throws Cancelled.
GaussianSet gaussians_seen(const Frame& frame, glm::ivec2 size, const Shape& shape, float weight,
                           ThreadPool& pool, std::stop_token stop = {});

}  // namespace qs
