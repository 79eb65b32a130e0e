// SPDX-License-Identifier: MIT
//
// Every CUDA runtime call goes through check(), every kernel launch through launch(). Both throw
// Error(device) with the message "cuda: WHAT: the runtime's reason".
#pragma once

#include <cstdint>
#include <string>

#include <cuda_runtime.h>

#include "raster/base/error.h"

namespace qs::cuda {

inline void check(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  cudaGetLastError();  // clears the error, so that the next check does not report it again
  throw Error(ErrorKind::device, std::string("cuda: ") + what + ": " + cudaGetErrorString(error));
}

/// Threads per block of kernels that use one thread per item.
inline constexpr unsigned kThreads = 256;

/// Number of blocks of kThreads threads that covers `items`, which must be below 2^39.
inline unsigned blocks_for(std::uint64_t items) {
  return static_cast<unsigned>((items + kThreads - 1) / kThreads);
}

/// Size of a launch: number of blocks, and threads per block.
struct Blocks {
  unsigned count, threads = kThreads;
  Blocks(unsigned count_) : count(count_) {}
  Blocks(unsigned count_, unsigned threads_) : count(count_), threads(threads_) {}
};

/// Enqueues a kernel in `stream`; `arguments` are passed by value.
template <class... Parameters, class... Arguments>
void launch(const char* what, void (*kernel)(Parameters...), Blocks blocks, cudaStream_t stream,
            Arguments... arguments) {
  cudaLaunchConfig_t config{};
  config.gridDim = dim3(blocks.count);
  config.blockDim = dim3(blocks.threads);
  config.stream = stream;
  check(cudaLaunchKernelEx(&config, kernel, Parameters(arguments)...), what);
}

}  // namespace qs::cuda
