// SPDX-License-Identifier: MIT
//
// Every call of the CUDA runtime goes through check(), every kernel through launch(). Both throw
// Error(device): "cuda: what: the runtime's reason".
#pragma once

#include <cstdint>
#include <string>

#include <cuda_runtime.h>

#include "raster/scene/error.h"

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

/// Launches blocks of kThreads threads; `arguments` are what the kernel takes, by value.
template <class... Parameters, class... Arguments>
void launch(const char* what, void (*kernel)(Parameters...), unsigned blocks, cudaStream_t stream,
            Arguments... arguments) {
  cudaLaunchConfig_t config{};
  config.gridDim = dim3(blocks);
  config.blockDim = dim3(kThreads);
  config.stream = stream;
  check(cudaLaunchKernelEx(&config, kernel, Parameters(arguments)...), what);
}

}  // namespace qs::cuda
