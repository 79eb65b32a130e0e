// SPDX-License-Identifier: MIT
//
// Arithmetic that flushes to zero: arguments and results below 2^-126, the smallest normal float,
// become 0. One named function per instruction; the emulated tests compute the same.
#pragma once

#include <cmath>
#include <limits>

#include <cuda_runtime.h>

namespace qs::cuda {

#ifndef __CUDA_ARCH__
/// `value` rounded to a float, 0 if the result would be below the smallest normal float.
inline float flushed(double value) {
  constexpr double kScale = 0x1p64;  // rounds small values to the 24 bits of a normal float
  const double rounded = static_cast<double>(static_cast<float>(value * kScale)) / kScale;
  if (std::abs(rounded) < double{std::numeric_limits<float>::min()}) return 0.0f;
  return static_cast<float>(std::abs(value) < 1 ? rounded : value);
}
#endif

/// 2^x, relative error below 2^-22 (PTX ISA, ex2.approx). Faster than exp2_polynomial() of the CPU
/// backend and equally accurate.
__device__ inline float exp2_flush(float x) {
#ifdef __CUDA_ARCH__
  float result;
  asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
#else
  return flushed(std::exp2(double{x}));
#endif
}

__device__ inline float mul_flush(float a, float b) {
#ifdef __CUDA_ARCH__
  float result;
  asm("mul.ftz.f32 %0, %1, %2;" : "=f"(result) : "f"(a), "f"(b));
  return result;
#else
  return flushed(double{a} * double{b});
#endif
}

/// a * b + c, rounded once.
__device__ inline float fma_flush(float a, float b, float c) {
#ifdef __CUDA_ARCH__
  float result;
  asm("fma.rn.ftz.f32 %0, %1, %2, %3;" : "=f"(result) : "f"(a), "f"(b), "f"(c));
  return result;
#else
  return flushed(double{fmaf(a, b, c)});
#endif
}

/// 1 / x, relative error below 2^-22 (PTX ISA, rcp.approx).
__device__ inline float reciprocal_flush(float x) {
#ifdef __CUDA_ARCH__
  float result;
  asm("rcp.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
#else
  return flushed(1.0 / double{x});
#endif
}

/// Square root. Approximate: callers add a margin for rounding.
__device__ inline float sqrt_flush(float x) {
#ifdef __CUDA_ARCH__
  float result;
  asm("sqrt.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
#else
  return sqrtf(x);
#endif
}

}  // namespace qs::cuda
