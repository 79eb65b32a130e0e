// SPDX-License-Identifier: MIT
//
// The sub-tiles of 8x4 pixels of half a tile, and the test that decides if a Gaussian reaches them.
#pragma once

#include "raster/cuda/common/ellipse.cuh"
#include "raster/cuda/common/flush.cuh"
#include "raster/kernel/constants.h"

namespace qs::cuda {

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
