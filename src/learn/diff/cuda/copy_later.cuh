// SPDX-License-Identifier: MIT
//
// Copies of single numbers to shared memory for which a thread does not wait, so many of them are
// under way at once (cp.async of PTX, from compute capability 8.0 on; older GPUs wait for each).
#pragma once

#include "raster/cuda/common/check.cuh"

namespace qs::cuda::diff {

/// Starts to copy a number from global to shared memory.
__device__ inline void copy_later(float* to, const float* from) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 800
  asm volatile("cp.async.ca.shared.global [%0], [%1], 4;"
               :
               : "r"(static_cast<unsigned>(__cvta_generic_to_shared(to))), "l"(from)
               : "memory");
#else
  *to = *from;
#endif
}

/// Waits for the copies of this thread. Other threads see them behind a barrier.
__device__ inline void wait_for_copies() {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 800
  asm volatile("cp.async.wait_all;" : : : "memory");
#endif
}

}  // namespace qs::cuda::diff
