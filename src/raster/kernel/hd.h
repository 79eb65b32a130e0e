// SPDX-License-Identifier: MIT
//
// QS_HD marks a function that both g++ and nvcc compile. To give the same bits, all files that
// include kernel/ must be built without contraction (-ffp-contract=off, --fmad=false) and
// fast-math.
#pragma once

#if defined(__CUDACC__)
#define QS_HD __host__ __device__ __forceinline__
#else
#define QS_HD inline
#endif
