// SPDX-License-Identifier: MIT
//
// The ellipse of a Gaussian in an image, the sub-tiles of 8x4 pixels of half a tile, and the test
// that decides if a Gaussian reaches them.
#pragma once

#include "raster/cuda/common/flush.cuh"
#include "raster/kernel/constants.h"
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

/// The margin of AlphaEllipse for rounding.
inline constexpr float kEllipseWider = 1.0005f, kEllipseMarginPx = 0.01f;

/// Half the size of the box around the ellipse, px.
__device__ inline glm::vec2 half_box_of(const Footprint& footprint) {
  return extents(footprint).max * kEllipseWider + kEllipseMarginPx;
}

__device__ inline AlphaEllipse ellipse_of(const Footprint& footprint) {
  if (!(footprint.gamma > 0.0f)) return {-1, 0, 0, 0, 0};
  const glm::vec2 max = half_box_of(footprint);
  const glm::vec3 conic = footprint.conic;
  const float half2 = footprint.gamma / conic.x * (kEllipseWider * kEllipseWider);
  return {max.y, -conic.y / conic.x, -conic.y / conic.z * max.x, half2, half2 / (max.y * max.y)};
}

inline constexpr unsigned kSubWidth = 8, kSubHeight = 4;  ///< size of a sub-tile, px
inline constexpr unsigned kSubTiles = 4;                  ///< sub-tiles of half a tile, in two rows
/// Height of half a tile, px.
inline constexpr unsigned kHalfTileHeight = 2 * kSubHeight;
/// Halves of a tile, one above the other.
inline constexpr unsigned kHalfTiles = kTileSize / kHalfTileHeight;
static_assert(2 * kSubWidth == kTileSize);

/// The sub-tiles that may have a pixel centre inside the ellipse; index 2 * row + column. (x0, y0)
/// is the offset of the half's first pixel from the mean. Over a band of rows, the ellipse is
/// widest at its own extreme or at the end of the band nearest to it, as in ExactWalk.
struct Reach {
  bool reached[kSubTiles];

  __device__ Reach(const AlphaEllipse& ellipse, float x0, float y0) {
    constexpr float kMarginPx = 0.01f;  // for rounding
    const auto half_at = [&](float v) {
      return sqrt_flush(fmaxf(fmaf(-ellipse.narrowing * v, v, ellipse.half2), 0.0f));
    };
    const float first_x[2] = {x0 - kMarginPx, x0 + (kSubWidth - kMarginPx)};
    const float last_x[2] = {x0 + (kSubWidth - 1 + kMarginPx),
                             x0 + (2 * kSubWidth - 1 + kMarginPx)};
#pragma unroll
    for (unsigned s = 0; s < kSubTiles; s += 2) {
      const float low = y0 + static_cast<float>(s / 2 * kSubHeight);
      const float v0 = fmaxf(low, -ellipse.y_max);
      const float v1 = fminf(low + (kSubHeight - 1), ellipse.y_max);
      const float v_right = fminf(fmaxf(ellipse.v_extreme, v0), v1);
      const float v_left = fminf(fmaxf(-ellipse.v_extreme, v0), v1);
      const float right = fmaf(ellipse.slope, v_right, half_at(v_right));
      const float left = fmaf(ellipse.slope, v_left, -half_at(v_left));
#pragma unroll
      for (unsigned column = 0; column < 2; ++column)
        reached[s + column] = v0 <= v1 && left <= last_x[column] && right >= first_x[column];
    }
  }
};

}  // namespace qs::cuda
