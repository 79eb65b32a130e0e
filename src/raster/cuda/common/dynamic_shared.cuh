// SPDX-License-Identifier: MIT
//
// The shared memory of a block whose size is chosen at the launch, see Blocks::shared_bytes.
#pragma once

#include <cstdint>

namespace qs::cuda {

__device__ inline void* dynamic_shared() {
  extern __shared__ uint4 words[];
  return words;
}

}  // namespace qs::cuda
