// SPDX-License-Identifier: MIT
//
// Every call of the CUDA runtime goes through check(), every kernel through launch(). Both throw
// Error(device): "cuda: what: the runtime's reason".
#pragma once

#include <cstdint>
#include <string>

#include <cuda_runtime.h>

#include "raster/base/error.h"

namespace qs::cuda {

inline void check(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  cudaGetLastError();  // so that an error which can be survived is not reported twice
  throw Error(ErrorKind::device, std::string("cuda: ") + what + ": " + cudaGetErrorString(error));
}

/// Threads of a block wherever a kernel has one thread per item.
inline constexpr unsigned kThreads = 256;

/// Blocks of kThreads threads that cover `items`, fewer than 2^39.
inline unsigned blocks_for(std::uint64_t items) {
  return static_cast<unsigned>((items + kThreads - 1) / kThreads);
}

/// How many blocks a kernel gets, and of how many threads.
struct Blocks {
  unsigned count, threads = kThreads;
  Blocks(unsigned count_) : count(count_) {}
  Blocks(unsigned count_, unsigned threads_) : count(count_), threads(threads_) {}
};

/// Launches a kernel; `arguments` are what it takes, by value.
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
