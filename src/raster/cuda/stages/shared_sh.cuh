// SPDX-License-Identifier: MIT
//
// The coefficients of colour of a block's Gaussians in shared memory, with a thread per Gaussian.
// The lanes of a warp read and write neighbouring numbers of a caller's rows; threads that read
// rows of their own would wait for as many parts of the memory as there are lanes.
#pragma once

#include "raster/cuda/dynamic_shared.cuh"
#include "raster/cuda/warp.cuh"
#include "raster/kernel/hd.h"
#include "raster/stages/rows.h"

namespace qs::cuda::stages {

/// A kernel parameter. Without coefficients nothing is shared.
struct SharedSh {
  unsigned numbers = 0;  ///< per Gaussian; 0: nothing is shared

  /// Of rows with `coefficients` per Gaussian.
  static SharedSh of(bool exists, int coefficients) {
    return {exists ? 3 * static_cast<unsigned>(coefficients) : 0};
  }
  std::size_t bytes() const {
    return numbers > 0 ? std::size_t{kThreads} * stride() * sizeof(float) : 0;
  }

  /// Copies the rows of the lanes with `reads` to shared memory. Returns rows there, which only the
  /// warp may use. All lanes call it.
  __device__ qs::stages::ShRows<float> load(const qs::stages::ShRows<const float>& from,
                                            bool reads) const {
    for_each_number(__ballot_sync(kAllLanes, reads), [&](float& number, std::uint32_t i, int k,
                                                         int c) { number = from.at(i, k, c); });
    __syncwarp();
    return rows();
  }

  /// Copies the rows of the lanes with `writes` from shared memory. All lanes call it.
  __device__ void store(const qs::stages::ShRows<float>& to, bool writes) const {
    const unsigned lanes = __ballot_sync(kAllLanes, writes);
    __syncwarp();
    for_each_number(lanes, [&](const float& number, std::uint32_t i, int k, int c) {
      to.at(i, k, c) = number;
    });
  }

 private:
  /// Between the rows of two Gaussians: odd, so that the rows begin in different memory banks.
  QS_HD unsigned stride() const { return numbers | 1; }

  __device__ qs::stages::ShRows<float> rows() const {
    auto* const shared = static_cast<float*>(dynamic_shared());
    const auto row = static_cast<std::ptrdiff_t>(stride());
    float* const begin = shared - static_cast<std::ptrdiff_t>(blockIdx.x) * kThreads * row;
    return {{begin, row, 1}, {begin + 3, row, 1}, 3};
  }

  /// Calls visit(number in shared memory, Gaussian, coefficient, channel) for all numbers of the
  /// Gaussians of these lanes.
  template <class Visit>
  __device__ void for_each_number(unsigned lanes, const Visit& visit) const {
    auto* const shared = static_cast<float*>(dynamic_shared());
    const std::uint32_t first = threadIdx.x / kWarp * kWarp;  // of the warp in its block
    for (unsigned n = lane_index(); n < numbers; n += kWarp) {
      const int k = static_cast<int>(n / 3), c = static_cast<int>(n % 3);
#pragma unroll 8
      for (std::uint32_t row = 0; row < kWarp; ++row) {
        if ((lanes >> row & 1) != 0)
          visit(shared[(first + row) * stride() + n], blockIdx.x * kThreads + first + row, k, c);
      }
    }
  }
};

}  // namespace qs::cuda::stages
