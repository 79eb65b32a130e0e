// SPDX-License-Identifier: MIT
//
// The coefficients of colour of a block's Gaussians in shared memory, with a thread per Gaussian.
// The lanes of a warp read and write neighbouring numbers of a caller's rows; threads that read
// rows of their own would wait for as many parts of the memory as there are lanes.
#pragma once

#include "raster/cuda/dynamic_shared.cuh"
#include "raster/cuda/warp.cuh"
#include "raster/kernel/constants.h"
#include "raster/stages/rows.h"

namespace qs::cuda::stages {

/// A kernel parameter. Without coefficients the rows of a caller stay as they are.
struct SharedSh {
  unsigned numbers = 0;  ///< per Gaussian; 0: nothing is shared

  /// Of rows with `coefficients` per Gaussian.
  static SharedSh of(bool exists, int coefficients) {
    return {exists ? 3 * static_cast<unsigned>(coefficients) : 0};
  }
  std::size_t bytes() const {
    return numbers > 0 ? std::size_t{kThreads} * stride() * sizeof(float) : 0;
  }

  /// Calls visit(number in shared memory, Gaussian, coefficient, channel) for all numbers of the
  /// block's Gaussians below `count`.
  template <class Visit>
  __device__ void for_each(std::uint32_t count, const Visit& visit) const {
    auto* const shared = static_cast<float*>(dynamic_shared());
    const std::uint32_t first = blockIdx.x * kThreads;
    const std::uint32_t size = min(count - first, kThreads);
    for (std::uint32_t row = threadIdx.x / kWarp; row < size; row += kThreads / kWarp) {
      for (unsigned n = lane_index(); n < numbers; n += kWarp)
        visit(shared[row * stride() + n], first + row, static_cast<int>(n / 3),
              static_cast<int>(n % 3));
    }
  }

  /// Copies rows to shared memory and waits. Returns rows there, for this block's Gaussians.
  __device__ qs::stages::ShRows<float> load(const qs::stages::ShRows<const float>& from,
                                            std::uint32_t count) const {
    for_each(count,
             [&](float& number, std::uint32_t i, int k, int c) { number = from.at(i, k, c); });
    __syncthreads();
    return rows();
  }

  /// Rows in shared memory, for this block's Gaussians.
  __device__ qs::stages::ShRows<float> rows() const {
    auto* const shared = static_cast<float*>(dynamic_shared());
    const auto row = static_cast<std::ptrdiff_t>(stride());
    float* const begin = shared - static_cast<std::ptrdiff_t>(blockIdx.x) * kThreads * row;
    return {{begin, row, 1}, {begin + 3, row, 1}, 3};
  }

  /// Waits and copies the rows from shared memory. All threads of the block call it.
  __device__ void store(const qs::stages::ShRows<float>& to, std::uint32_t count) const {
    __syncthreads();
    for_each(count,
             [&](const float& number, std::uint32_t i, int k, int c) { to.at(i, k, c) = number; });
  }

 private:
  /// Between the rows of two Gaussians: odd, so that the rows begin in different memory banks.
  QS_HD unsigned stride() const { return numbers | 1; }
};

}  // namespace qs::cuda::stages
