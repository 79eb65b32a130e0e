// SPDX-License-Identifier: MIT
//
// The ellipse of a Gaussian in an image.
#pragma once

#include "raster/cuda/common/flush.cuh"
#include "raster/kernel/cull/culler.h"

namespace qs::cuda {

/// The ellipse in which alpha >= 1/255, relative to the mean. In the row v pixels below the mean it
/// spans slope v +- sqrt(half2 - narrowing v^2), if |v| <= y_max. It is enlarged by a margin for
/// rounding, and does not depend on the culling mode, so lossless modes stay equal bit for bit.
struct AlphaEllipse {
  float y_max;      ///< < 0: the ellipse is empty
  float slope;      ///< slope of the line through the centres of the rows' spans
  float v_extreme;  ///< row of the rightmost point; -v_extreme is the row of the leftmost point
  float half2, narrowing;
};

__device__ inline AlphaEllipse ellipse_of(const Footprint& footprint) {
  if (!(footprint.gamma > 0.0f)) return {-1, 0, 0, 0, 0};
  constexpr float kWider = 1.0005f, kMarginPx = 0.01f;
  const glm::vec2 max = extents(footprint).max * kWider + kMarginPx;
  const glm::vec3 conic = footprint.conic;
  const float half2 = footprint.gamma / conic.x * (kWider * kWider);
  return {max.y, -conic.y / conic.x, -conic.y / conic.z * max.x, half2, half2 / (max.y * max.y)};
}

}  // namespace qs::cuda
