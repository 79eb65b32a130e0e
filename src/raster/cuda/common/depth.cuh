// SPDX-License-Identifier: MIT
//
// Passes over the tile lists of a drawn frame, and the pass for its alpha and depth
// (Outputs::depth).
#pragma once

#include "raster/cuda/common/flush.cuh"
#include "raster/cuda/common/pixels.cuh"
#include "raster/kernel/depth.h"

namespace qs::cuda {

/// A Gaussian of a tile's list, with the value that a pass needs.
template <class Value>
struct PassEntry {
  float x, y, xx, xy, yy, log2_opacity;
  Value value;

  __device__ float log2_alpha(float pixel_x, float pixel_y) const {
    const float dx = x - pixel_x, dy = y - pixel_y;
    return fmaf(fmaf(xx, dx, xy * dy), dx, fmaf(yy * dy, dy, log2_opacity));
  }
};

/// A pass over the tile lists of a drawn frame, a block per tile and a thread per pixel. `Pass` has
///   value_of(gaussian): the value of a Gaussian, by its index into the splats
///   takes(x, y): false for pixels that the pass does not need
///   Pixel: the state of a pixel, with a transmittance
///   add(pixel, alpha, value, next): blends a Gaussian; `next` is the transmittance behind it
///   store(at, pixel): keeps the result of the pixel number `at`
/// The same for both pipelines; frames without passes run no other kernels.
template <class Entry, class Pass>
__global__ void __launch_bounds__(kThreads) walk_tiles(BlendInput<Entry> in, Pass pass) {
  static_assert(kThreads == kTileSize * kTileSize);
  using Value = decltype(pass.value_of(0));
  __shared__ PassEntry<Value> batch[kThreads];
  const unsigned tile = blockIdx.x, thread = threadIdx.x;
  const int x = static_cast<int>(tile % in.columns * kTileSize + thread % kTileSize);
  const int y = static_cast<int>(tile / in.columns * kTileSize + thread / kTileSize);
  const bool inside = x < in.width && y < in.height && pass.takes(x, y);
  const ListRange range = in.ranges[tile];

  typename Pass::Pixel pixel;
  bool live = inside;
  for (std::uint32_t first = range.begin; first < range.end; first += kThreads) {
    if (__syncthreads_count(live) == 0) break;
    if (first + thread < range.end) {
      const std::uint32_t gaussian = in.gaussians[first + thread];
      const Entry& splat = in.splats[gaussian];
      batch[thread] = {splat.x,
                       splat.y,
                       splat.xx,
                       splat.xy,
                       splat.yy,
                       splat.log2_opacity,
                       pass.value_of(gaussian)};
    }
    __syncthreads();
    const int size = static_cast<int>(min(range.end - first, kThreads));
    for (int k = 0; live && k < size; ++k) {
      const PassEntry<Value>& entry = batch[k];
      const float log2_alpha = entry.log2_alpha(static_cast<float>(x), static_cast<float>(y));
      // A larger alpha than the opacity comes from a conic that rounding broke. False for NaN.
      if (!(log2_alpha >= -kLog2Of255 && log2_alpha <= entry.log2_opacity)) continue;
      const float alpha = fminf(exp2_flush(log2_alpha), kAlphaMax);
      const float next = fmaf(-alpha, pixel.transmittance, pixel.transmittance);
      if (next < kTransmittanceMin)
        live = false;
      else
        pass.add(pixel, alpha, entry.value, next);
    }
  }
  if (inside) pass.store(static_cast<std::size_t>(y) * in.width + x, pixel);
}

/// The maps of Outputs::depth, see DepthMaps. Passed by value.
struct DepthPass {
  const float* depths;  ///< indexed as the splats
  float *alpha, *expected, *median;

  using Pixel = PixelDepth<float>;
  __device__ float value_of(std::uint32_t gaussian) const { return depths[gaussian]; }
  __device__ bool takes(int, int) const { return true; }
  __device__ void add(Pixel& pixel, float a, float depth, float next) const {
    pixel.add(a, depth, next);
  }
  __device__ void store(std::size_t at, const Pixel& pixel) const {
    alpha[at] = pixel.alpha();
    expected[at] = pixel.expected();
    median[at] = pixel.median;
  }
};

/// Fills Pixels::depth, which has its size. `in` has the lists and splats of the frame.
template <class Entry>
void draw_depth(const FrameContext& frame, const BlendInput<Entry>& in, const float* depths,
                Pixels& pixels) {
  const std::size_t count = Pixels::count_of(frame.camera);
  float* const maps = pixels.depth.data();
  launch("depth", walk_tiles<Entry, DepthPass>, static_cast<unsigned>(frame.grid.count()),
         frame.stream, in, DepthPass{depths, maps, maps + count, maps + 2 * count});
}

}  // namespace qs::cuda
