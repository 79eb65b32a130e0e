// SPDX-License-Identifier: MIT
//
// The sub-tiles of 8x4 pixels that a warp composites, and which of them a Gaussian reaches.
#pragma once

#include "raster/cuda/fast/column.cuh"
#include "raster/cuda/fast/preprocess.cuh"
#include "raster/cuda/fast/warp.cuh"

namespace qs::cuda::fast {

constexpr unsigned kSubWidth = 8, kSubHeight = kPixels;   // of a sub-tile in pixels
constexpr unsigned kWarpHeight = 2 * kSubHeight;          // pixel rows of a warp
constexpr unsigned kTileWarps = kTileSize / kWarpHeight;  // warps of a tile, one above the other
constexpr unsigned kSubTiles = 4;                         // of a warp, in two rows
constexpr unsigned kLanes = kWarp / kSubTiles;            // of a sub-tile, a column of pixels each
static_assert(kLanes == kSubWidth && 2 * kSubWidth == kTileSize);

/// The sub-tiles that may have a pixel centre inside the ellipse, as a mask of bits 2 * row +
/// column. (x0, y0) is the offset of the warp's first pixel from the mean. Over a band of rows, the
/// ellipse is widest at its own extreme or at the end of the band nearest to it, as in ExactWalk.
__device__ inline unsigned reached_sub_tiles(const AlphaEllipse& ellipse, float x0, float y0) {
  const auto half_at = [&](float v) {
    return sqrt_flush(fmaxf(fmaf(-ellipse.narrowing * v, v, ellipse.half2), 0.0f));
  };
  constexpr float kMarginPx = 0.01f;  // for rounding
  unsigned reached = 0;
#pragma unroll
  for (unsigned s = 0; s < kSubTiles; s += 2) {
    const float low = y0 + static_cast<float>(s / 2 * kSubHeight);
    const float v0 = fmaxf(low, -ellipse.y_max);
    const float v1 = fminf(low + (kSubHeight - 1), ellipse.y_max);
    const float v_right = fminf(fmaxf(ellipse.v_extreme, v0), v1);
    const float v_left = fminf(fmaxf(-ellipse.v_extreme, v0), v1);
    const float right = fmaf(ellipse.slope, v_right, half_at(v_right)) + kMarginPx;
    const float left = fmaf(ellipse.slope, v_left, -half_at(v_left)) - kMarginPx;
#pragma unroll
    for (unsigned column = 0; column < 2; ++column) {
      const float first = x0 + static_cast<float>(column * kSubWidth);
      const bool meets = v0 <= v1 && left <= first + (kSubWidth - 1) && right >= first;
      reached |= meets ? 1u << (s + column) : 0;
    }
  }
  return reached;
}

}  // namespace qs::cuda::fast
