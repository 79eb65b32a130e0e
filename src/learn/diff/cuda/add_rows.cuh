// SPDX-License-Identifier: MIT
//
// Adds up rows of numbers in double precision, in an order that does not depend on the order in
// which threads run.
#pragma once

#include "raster/cuda/common/warp.cuh"

namespace qs::cuda::diff {

/// out[k] is the sum of number k of all rows, which are packed. One block.
template <class Out>
__global__ void __launch_bounds__(kThreads)
    add_rows(const double* rows, unsigned count, unsigned numbers, Out* out) {
  for (unsigned k = 0; k < numbers; ++k) {
    double own = 0;
    for (unsigned row = threadIdx.x; row < count; row += kThreads)
      own += rows[std::size_t{row} * numbers + k];
    const double sum = sum_of_block<kThreads>(own).total;
    if (threadIdx.x == 0) out[k] = static_cast<Out>(sum);
  }
}

}  // namespace qs::cuda::diff
