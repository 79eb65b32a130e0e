// SPDX-License-Identifier: MIT
//
// The coefficients of colour of a block's Gaussians in shared memory, with a thread per Gaussian.
// The lanes of a warp read and write neighbouring numbers of a caller's rows; threads that read
// rows of their own would wait for as many parts of the memory as there are lanes.
#pragma once

#include <glm/vec3.hpp>

#include "learn/diff/strided_arrays.h"
#include "raster/cuda/common/dynamic_shared.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/kernel/hd.h"

namespace qs::cuda::diff {

// Copies of single numbers to shared memory for which a thread does not wait, so many of them are
// under way at once (cp.async of PTX, from compute capability 8.0 on; older GPUs wait for each).

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

/// A kernel parameter. Without coefficients nothing is shared.
struct SharedSh {
  unsigned numbers = 0;  ///< per Gaussian; 0: nothing is shared

  /// The memory for rows with `coefficients` per Gaussian.
  static SharedSh of(bool exists, int coefficients) {
    return {exists ? 3 * static_cast<unsigned>(coefficients) : 0};
  }
  std::size_t bytes() const {
    return numbers > 0 ? std::size_t{kThreads} * stride() * sizeof(float) : 0;
  }

  /// The coefficients of a thread's Gaussian, or their derivatives.
  struct Row {
    float* numbers;

    __device__ glm::vec3 operator()(int k) const {
      return {numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]};
    }
    __device__ void set(int k, const glm::vec3& value) const {
      for (int c = 0; c < 3; ++c) numbers[3 * k + c] = value[c];
    }
  };

  /// Copies the rows of the lanes with `reads` to shared memory. Returns this thread's row there.
  /// All lanes call it.
  __device__ Row load(const qs::diff::ShRows<const float>& from, bool reads) const {
    for_each_number(from, __ballot_sync(kAllLanes, reads),
                    [](float* shared, const float* number) { copy_later(shared, number); });
    wait_for_copies();
    __syncwarp();
    return {row_of(threadIdx.x)};
  }

  /// Copies the rows of the lanes with `writes` from shared memory. All lanes call it.
  __device__ void store(const qs::diff::ShRows<float>& to, bool writes) const {
    const unsigned lanes = __ballot_sync(kAllLanes, writes);
    __syncwarp();
    for_each_number(to, lanes, [](const float* shared, float* number) { *number = *shared; });
  }

 private:
  /// Between the rows of two Gaussians: odd, so that the rows begin in different memory banks.
  QS_HD unsigned stride() const { return numbers | 1; }

  __device__ float* row_of(unsigned thread) const {
    return static_cast<float*>(dynamic_shared()) + thread * stride();
  }

  /// Calls visit(number in shared memory, number of the caller) for all numbers of the Gaussians of
  /// these lanes.
  template <class T, class Visit>
  __device__ void for_each_number(const qs::diff::ShRows<T>& callers, unsigned lanes,
                                  const Visit& visit) const {
    const unsigned first = threadIdx.x / kWarp * kWarp;  // of the warp in its block
    for (unsigned n = lane_index(); n < numbers; n += kWarp) {
      const int k = static_cast<int>(n / 3), c = static_cast<int>(n % 3);
      T* number = &callers.at(std::size_t{blockIdx.x} * kThreads + first, k, c);
      const std::ptrdiff_t step = k == 0 ? callers.dc.row : callers.rest.row;
      float* shared = row_of(first) + n;
#pragma unroll 8
      for (unsigned row = 0; row < kWarp; ++row, number += step, shared += stride())
        if ((lanes >> row & 1) != 0) visit(shared, number);
    }
  }
};

}  // namespace qs::cuda::diff
