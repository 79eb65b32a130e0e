// SPDX-License-Identifier: MIT
//
// QS_HD marks a function that g++ and nvcc both compile. Everything under kernel/ is written once
// for both; bit-equal decisions rest on every such translation unit being built without contraction
// (-ffp-contract=off, --fmad=false) and without fast-math.
#pragma once

#if defined(__CUDACC__)
#define QS_HD __host__ __device__ __forceinline__
#else
#define QS_HD inline
#endif
