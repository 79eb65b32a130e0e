// SPDX-License-Identifier: MIT
//
// Every file with vector code includes this header last. Such a file is compiled once for each
// instruction set (scalar, SSE4, AVX2 and AVX-512 on x86; their counterparts on other CPUs), and
// the program chooses the best set that the CPU supports when it runs. The pattern:
//
//   #define HWY_TARGET_INCLUDE "raster/cpu/fast/this_file.cpp"
//   #include "base/simd.h"
//   HWY_BEFORE_NAMESPACE();
//   namespace qs::cpu::fast { namespace HWY_NAMESPACE { ... } }
//   HWY_AFTER_NAMESPACE();
//   #if HWY_ONCE
//   HWY_EXPORT(f);  void g() { HWY_DYNAMIC_DISPATCH(f)(); }
//   #endif
//
// Decisions (which Gaussians, which tiles) use + - * / sqrt in the order of kernel/ and never
// MulAdd, so that all instruction sets give the same bits. Only colours and blending use MulAdd.

// The disabled instruction sets add nothing that this code uses. QUADSPLAT_FEW_INSTRUCTION_SETS
// leaves out more, for builds that compile quickly: the code is the same with other widths.
#ifndef HWY_DISABLED_TARGETS
#ifdef QUADSPLAT_FEW_INSTRUCTION_SETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3 | HWY_AVX3_DL)
#else
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#endif
#endif

// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on
