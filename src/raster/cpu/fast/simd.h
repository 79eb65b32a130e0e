// SPDX-License-Identifier: MIT
//
// What every file with vector code includes first. Such a file is compiled once for each
// instruction set (none, SSE4, AVX2, AVX-512; elsewhere what the machine has), and the best one
// that the CPU knows is chosen when the program runs. Its pattern:
//
//   #define HWY_TARGET_INCLUDE "raster/cpu/fast/this_file.cpp"
//   #include "raster/cpu/fast/simd.h"
//   HWY_BEFORE_NAMESPACE();
//   namespace qs::cpu::fast { namespace HWY_NAMESPACE { ... } }
//   HWY_AFTER_NAMESPACE();
//   #if HWY_ONCE
//   HWY_EXPORT(f);  void g() { HWY_DYNAMIC_DISPATCH(f)(); }
//   #endif
//
// Decisions (which Gaussians, which tiles) use + - * / sqrt in the order of kernel/ and never
// MulAdd, so that they are equal to the bit on every instruction set; blending may use it.

// The sets between those named differ in instructions that nothing here uses.
#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#endif

// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on
