// SPDX-License-Identifier: MIT
//
// Compositing of one Gaussian onto the pixels of one lane: the inner loop of the blend stage.
#pragma once

#include "raster/cuda/flush.cuh"
#include "raster/kernel/constants.h"

namespace qs::cuda::fast {

constexpr int kPixels = 4;  // of a lane, one above the other

/// A Gaussian as it is composited onto one sub-tile. At column X, counted from the sub-tile's
/// middle, log2 alpha in its first row is c0 + c1 X + c2 X^2. From there to the second row it grows
/// by d0 + d1 X, and from row to row that growth itself grows by a constant, log2 of `bend`.
struct Staged {
  float4 shape;  // c0, c1, c2, d0
  float4 rest;   // d1, bend, red, green
  float blue;    // all colours without the background
};

/// The way in which pixels detect alpha < 1/255.
enum class Cut {
  flush,  ///< alphas are scaled so that 1/255 is the smallest normal float: smaller alphas become 0
  compare  ///< alphas are compared, which costs an instruction and is as exact as on the CPU
};

template <Cut kCut>
constexpr float kAlphaScale = kCut == Cut::flush ? 255 * 0x1p-126f : 1.0f;

/// The transmittance of an empty pixel, so that alpha times transmittance is the plain weight.
template <Cut kCut>
constexpr float kClear = kCut == Cut::flush ? 0x1p126f / 255 : 1.0f;

/// The state of one pixel during compositing. `red`, `green` and `blue` begin with the background,
/// which staged colours do not contain. Transmittance goes on falling after the pixel has stopped.
template <Cut kCut>
struct ColumnPixel {
  float transmittance;  ///< scaled by kClear
  float red, green, blue;

  __device__ bool is_live() const { return transmittance >= kTransmittanceMin * kClear<kCut>; }

  /// `alpha` is scaled by kAlphaScale. The Gaussian is skipped if alpha < 1/255, and the pixel
  /// stops if its transmittance falls below kTransmittanceMin.
  __device__ void add(float alpha, float4 rest, float more_blue) {
    if (kCut == Cut::compare && !(alpha >= kAlphaMin)) return;
    const float weight = mul_flush(alpha, transmittance);
    transmittance = fma_flush(weight, -kClear<kCut>, transmittance);
    if (!is_live()) return;
    red = fmaf(weight, rest.z, red);
    green = fmaf(weight, rest.w, green);
    blue = fmaf(weight, more_blue, blue);
  }
};

/// The pixels of a lane, from top to bottom. fmaf is explicit because compilers may not contract
/// (kernel/hd.h).
template <Cut kCut>
struct Column {
  float x;  // counted from the sub-tile's middle
  ColumnPixel<kCut> pixels[kPixels];

  __device__ bool any_live() const {
    bool any = false;
    for (const ColumnPixel<kCut>& pixel : pixels) any = any || pixel.is_live();
    return any;
  }

  /// Alphas of the rows are products of two exponentials (Turkowski, GPU Gems 3, chapter 40).
  /// kClamps: limits alpha to kAlphaMax, which few Gaussians exceed.
  template <bool kClamps>
  __device__ void add(float4 shape, float4 rest, float more_blue) {
    static_assert(kPixels == 4);
    const float first = exp2_flush(fmaf(fmaf(shape.z, x, shape.y), x, shape.x));
    const float growth1 = exp2_flush(fmaf(rest.x, x, shape.w));
    const float growth2 = mul_flush(growth1, rest.y), growth3 = mul_flush(growth2, rest.y);
    const float second = mul_flush(growth1, kAlphaScale<kCut>);
    const float third = mul_flush(second, growth2), fourth = mul_flush(third, growth3);
    float alphas[kPixels] = {mul_flush(first, kAlphaScale<kCut>), mul_flush(first, second),
                             mul_flush(first, third), mul_flush(first, fourth)};
#pragma unroll
    for (int j = 0; j < kPixels; ++j) {
      if (kClamps) alphas[j] = fminf(alphas[j], kAlphaMax * kAlphaScale<kCut>);
      pixels[j].add(alphas[j], rest, more_blue);
    }
  }
};

}  // namespace qs::cuda::fast
