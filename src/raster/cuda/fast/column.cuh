// SPDX-License-Identifier: MIT
//
// Compositing of one Gaussian onto the pixels of one lane: the inner loop of the blend stage.
#pragma once

#include <cmath>

#include "raster/kernel/constants.h"

namespace qs::cuda::fast {

constexpr int kPixels = 4;  // of a lane, one above the other

/// The values of a BoundedSplat that compositing needs, in shared memory.
struct Staged {
  float4 shape;  // x, y, xx, xy
  float4 level;  // yy, log2_opacity, alpha_max, red
  float2 color;  // green, blue; all colours without the background
  float2 unused;
};

/// The state of one pixel during compositing. `red`, `green` and `blue` begin with the background,
/// which staged colours do not contain. Transmittance goes on falling after the pixel has stopped.
struct Pixel {
  float transmittance;
  float red, green, blue;

  __device__ bool is_live() const { return transmittance >= kTransmittanceMin; }
};

/// Approximate: relative error below 2^-22 (PTX ISA), and results below 2^-126 are 0.
__device__ inline float exp2_fast(float x) {
#ifdef __CUDA_ARCH__
  float result;
  asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
#else
  return exp2f(x);
#endif
}

/// Composites one Gaussian onto one pixel with alpha = min(2^log2_alpha, alpha_max). It is skipped
/// if alpha < 1/255, and the pixel stops if its transmittance falls below kTransmittanceMin.
__device__ inline void composite(float log2_alpha, const Staged& splat, Pixel& pixel) {
  const bool counts = log2_alpha >= -kLog2Of255;
  const float weight = fminf(exp2_fast(log2_alpha), splat.level.z) * pixel.transmittance;
  if (counts) pixel.transmittance -= weight;
  if (counts && pixel.is_live()) {
    pixel.red = fmaf(weight, splat.level.w, pixel.red);
    pixel.green = fmaf(weight, splat.color.x, pixel.green);
    pixel.blue = fmaf(weight, splat.color.y, pixel.blue);
  }
}

/// The pixels of a lane, from top to bottom. fmaf is explicit because compilers may not contract
/// (kernel/hd.h).
struct Column {
  float x, y;  // of the second pixel
  Pixel pixels[kPixels];

  __device__ bool any_live() const {
    bool any = false;
    for (const Pixel& pixel : pixels) any = any || pixel.is_live();
    return any;
  }

  __device__ void add(const Staged& splat) {
    static_assert(kPixels == 4);
    const float4 shape = splat.shape, level = splat.level;
    const float dx = x - shape.x, dy = y - shape.y;
    const float along = fmaf(shape.z * dx, dx, level.y), across = shape.w * dx;
    const float here = fmaf(fmaf(level.x, dy, across), dy, along);
    const float growth = fmaf(level.x, dy + dy, across);
    composite(here - (growth - level.x), splat, pixels[0]);
    composite(here, splat, pixels[1]);
    composite(here + (growth + level.x), splat, pixels[2]);
    composite(fmaf(2.0f, fmaf(2.0f, level.x, growth), here), splat, pixels[3]);
  }
};

}  // namespace qs::cuda::fast
