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
  float2 color;  // green, blue
  float2 unused;
};

/// The state of one pixel during compositing. A pixel that has stopped keeps its transmittance with
/// a negative sign.
struct Pixel {
  float transmittance;
  float red = 0, green = 0, blue = 0;
};

/// Composites one Gaussian onto one pixel with alpha = min(2^log2_alpha, alpha_max). It is skipped
/// if alpha < 1/255, and the pixel stops if its transmittance would fall below kTransmittanceMin.
/// Assembly keeps the device code free of branches: 11 instructions, in which one comparison sets
/// both `adds` and `stops`. A negative transmittance never passes that comparison.
__device__ inline void composite(float log2_alpha, const Staged& splat, Pixel& pixel) {
  constexpr float kLog2Min = -kLog2Of255;
#ifdef __CUDA_ARCH__
  asm("{\n\t"
      ".reg .pred counts, adds, stops;\n\t"
      ".reg .f32 alpha, weight, next;\n\t"
      "setp.ge.f32 counts, %4, %9;\n\t"
      "ex2.approx.ftz.f32 alpha, %4;\n\t"  // relative error below 2^-22 (PTX ISA)
      "min.f32 alpha, alpha, %5;\n\t"
      "mul.f32 weight, alpha, %0;\n\t"
      "sub.f32 next, %0, weight;\n\t"
      "setp.ge.and.f32 adds|stops, next, %10, counts;\n\t"
      "@adds fma.rn.f32 %1, weight, %6, %1;\n\t"
      "@adds fma.rn.f32 %2, weight, %7, %2;\n\t"
      "@adds fma.rn.f32 %3, weight, %8, %3;\n\t"
      "@adds mov.f32 %0, next;\n\t"
      "@stops or.b32 %0, %0, 0x80000000;\n\t"
      "}"
      : "+f"(pixel.transmittance), "+f"(pixel.red), "+f"(pixel.green), "+f"(pixel.blue)
      : "f"(log2_alpha), "f"(splat.level.z), "f"(splat.level.w), "f"(splat.color.x),
        "f"(splat.color.y), "f"(kLog2Min), "f"(kTransmittanceMin));
#else
  if (!(log2_alpha >= kLog2Min)) return;  // in the emulated tests
  const float weight = fminf(exp2f(log2_alpha), splat.level.z) * pixel.transmittance;
  const float next = pixel.transmittance - weight;
  if (next >= kTransmittanceMin) {
    pixel.red = fmaf(weight, splat.level.w, pixel.red);
    pixel.green = fmaf(weight, splat.color.x, pixel.green);
    pixel.blue = fmaf(weight, splat.color.y, pixel.blue);
    pixel.transmittance = next;
  } else {
    pixel.transmittance = -fabsf(pixel.transmittance);
  }
#endif
}

/// The pixels of a lane, from top to bottom. fmaf is explicit because compilers may not contract
/// (kernel/hd.h).
struct Column {
  float x, y;  // of the second pixel
  Pixel pixels[kPixels];

  __device__ bool any_live() const {
    bool any = false;
    for (const Pixel& pixel : pixels) any = any || pixel.transmittance > 0.0f;
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
