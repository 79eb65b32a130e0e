// SPDX-License-Identifier: MIT
#include "raster/cuda/classic/classic.cuh"
#include "raster/cuda/common/flush.cuh"
#include "raster/cuda/common/pixels.cuh"

namespace qs::cuda::classic {
namespace {

static_assert(kThreads == kTileSize * kTileSize);

using Input = BlendInput<LogSplat>;

/// The state of one pixel during compositing. fmaf is explicit because compilers may not contract
/// (kernel/hd.h); it affects only the last bits of a colour.
struct Pixel {
  float x, y;
  float transmittance = 1;
  float red = 0, green = 0, blue = 0;

  __device__ float log2_alpha(const LogSplat& splat) const {
    const float dx = splat.x - x, dy = splat.y - y;
    return fmaf(fmaf(splat.xx, dx, splat.xy * dy), dx, fmaf(splat.yy * dy, dy, splat.log2_opacity));
  }

  __device__ void add(const LogSplat& splat, float weight, float next_transmittance) {
    red = fmaf(weight, splat.red, red);
    green = fmaf(weight, splat.green, green);
    blue = fmaf(weight, splat.blue, blue);
    transmittance = next_transmittance;
  }
};

/// True if alpha is at least 1/255 and at most the opacity. Alpha exceeds the opacity only if
/// rounding broke the conic. False for NaN.
__device__ bool counts(float log2_alpha, const LogSplat& splat) {
  return log2_alpha >= -kLog2Of255 && log2_alpha <= splat.log2_opacity;
}

/// kMarksUsed: fills BlendOutput::used, which costs one store per contribution.
template <bool kMarksUsed>
__global__ void __launch_bounds__(kThreads)
    blend_tiles(Input in, BlendOutput out, ClassicCounters* counters) {
  __shared__ LogSplat batch[kThreads];
  const unsigned tile = blockIdx.x, thread = threadIdx.x;
  const int x = static_cast<int>(tile % in.columns * kTileSize + thread % kTileSize);
  const int y = static_cast<int>(tile / in.columns * kTileSize + thread / kTileSize);
  const bool inside = x < in.width && y < in.height;
  const auto [begin, end] = in.ranges[tile];
  if (thread == 0) atomicMax(&counters->max_pairs_in_a_tile, end - begin);
  if (!kMarksUsed && out.color == nullptr && out.evaluated == nullptr) return;

  Pixel pixel{static_cast<float>(x), static_cast<float>(y)};
  std::uint32_t evaluated = end - begin;
  bool live = inside;
  for (std::uint32_t first = begin; first < end; first += kThreads) {
    if (__syncthreads_count(live) == 0) break;
    if (first + thread < end) batch[thread] = in.splats[in.gaussians[first + thread]];
    __syncthreads();
    const int size = static_cast<int>(min(end - first, kThreads));
    if (!live) continue;
#pragma unroll 4
    for (int k = 0; k < size; ++k) {
      const LogSplat& splat = batch[k];
      const float log2_alpha = pixel.log2_alpha(splat);
      if (!counts(log2_alpha, splat)) continue;
      const float alpha = fminf(exp2_flush(log2_alpha), kAlphaMax);
      const float next = fmaf(-alpha, pixel.transmittance, pixel.transmittance);
      if (next < kTransmittanceMin) {
        live = false;
        evaluated = first - begin + k + 1;
        break;
      }
      pixel.add(splat, alpha * pixel.transmittance, next);
      if constexpr (kMarksUsed) out.used[first + k] = 1;
    }
  }

  if (!inside) return;
  const std::size_t at = static_cast<std::size_t>(y) * in.width + x;
  if (out.evaluated != nullptr) out.evaluated[at] = evaluated;
  if (out.color != nullptr) {
    out.color[3 * at] = fmaf(pixel.transmittance, in.background.x, pixel.red);
    out.color[3 * at + 1] = fmaf(pixel.transmittance, in.background.y, pixel.green);
    out.color[3 * at + 2] = fmaf(pixel.transmittance, in.background.z, pixel.blue);
  }
}

}  // namespace

void blend(const FrameContext& frame, ClassicVisible& visible, const ClassicPairs& pairs,
           const Outputs& outputs, Pixels& pixels) {
  pixels.reserve(frame.camera, outputs);
  pixels.reserve_used(outputs, pairs.count);
  pixels.clear_used(outputs, pairs.count, frame.stream);
  launch("blend", outputs.used ? blend_tiles<true> : blend_tiles<false>,
         static_cast<unsigned>(frame.grid.count()), frame.stream,
         Input::of(frame, pairs.ranges.data(), pairs.buffers.values.data(), visible.splats.data()),
         BlendOutput::of(pixels, outputs), visible.counters.data());
}

}  // namespace qs::cuda::classic
