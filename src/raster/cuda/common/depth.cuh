// SPDX-License-Identifier: MIT
//
// Alpha and depth of a drawn frame (Outputs::depth): a pass over its tile lists, a block per tile
// and a thread per pixel. The same for both pipelines; frames without it run no other kernels.
#pragma once

#include "raster/cuda/common/flush.cuh"
#include "raster/cuda/common/pixels.cuh"
#include "raster/kernel/depth.h"

namespace qs::cuda {

/// Per pixel, see DepthMaps. Passed by value.
struct DepthOutput {
  float *alpha, *expected, *median;
};

/// A Gaussian of a tile's list.
struct DepthEntry {
  float x, y, xx, xy, yy, log2_opacity, depth;

  __device__ float log2_alpha(float pixel_x, float pixel_y) const {
    const float dx = x - pixel_x, dy = y - pixel_y;
    return fmaf(fmaf(xx, dx, xy * dy), dx, fmaf(yy * dy, dy, log2_opacity));
  }
};

/// `depths` are indexed as the splats.
template <class Entry>
__global__ void __launch_bounds__(kThreads)
    draw_depth_tiles(BlendInput<Entry> in, const float* depths, DepthOutput out) {
  static_assert(kThreads == kTileSize * kTileSize);
  __shared__ DepthEntry batch[kThreads];
  const unsigned tile = blockIdx.x, thread = threadIdx.x;
  const int x = static_cast<int>(tile % in.columns * kTileSize + thread % kTileSize);
  const int y = static_cast<int>(tile / in.columns * kTileSize + thread / kTileSize);
  const bool inside = x < in.width && y < in.height;
  const ListRange range = in.ranges[tile];

  PixelDepth<float> pixel;
  bool live = inside;
  for (std::uint32_t first = range.begin; first < range.end; first += kThreads) {
    if (__syncthreads_count(live) == 0) break;
    if (first + thread < range.end) {
      const std::uint32_t gaussian = in.gaussians[first + thread];
      const Entry& splat = in.splats[gaussian];
      batch[thread] = {splat.x,         splat.y, splat.xx, splat.xy, splat.yy, splat.log2_opacity,
                       depths[gaussian]};
    }
    __syncthreads();
    const int size = static_cast<int>(min(range.end - first, kThreads));
    for (int k = 0; live && k < size; ++k) {
      const DepthEntry& entry = batch[k];
      const float log2_alpha = entry.log2_alpha(static_cast<float>(x), static_cast<float>(y));
      // A larger alpha than the opacity comes from a conic that rounding broke. False for NaN.
      if (!(log2_alpha >= -kLog2Of255 && log2_alpha <= entry.log2_opacity)) continue;
      const float alpha = fminf(exp2_flush(log2_alpha), kAlphaMax);
      const float next = fmaf(-alpha, pixel.transmittance, pixel.transmittance);
      if (next < kTransmittanceMin)
        live = false;
      else
        pixel.add(alpha, entry.depth, next);
    }
  }

  if (!inside) return;
  const std::size_t at = static_cast<std::size_t>(y) * in.width + x;
  out.alpha[at] = pixel.alpha();
  out.expected[at] = pixel.expected();
  out.median[at] = pixel.median;
}

/// Fills Pixels::depth, which has its size. `in` has the lists and splats of the frame.
template <class Entry>
void draw_depth(const FrameContext& frame, const BlendInput<Entry>& in, const float* depths,
                Pixels& pixels) {
  const std::size_t count = Pixels::count_of(frame.camera);
  float* const maps = pixels.depth.data();
  launch("depth", draw_depth_tiles<Entry>, static_cast<unsigned>(frame.grid.count()), frame.stream,
         in, depths, DepthOutput{maps, maps + count, maps + 2 * count});
}

}  // namespace qs::cuda
