// SPDX-License-Identifier: MIT
//
// Every CUDA runtime call goes through check(), every kernel launch through launch(). Both throw
// Error(device) with the message "cuda: WHAT: the runtime's reason".
#pragma once

#include <cstdint>
#include <string>

#include <cuda_runtime.h>

#include "base/error.h"

namespace qs::cuda {

inline void check(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  cudaGetLastError();  // clears the error, so that the next check does not report it again
  throw Error(ErrorKind::device, std::string("cuda: ") + what + ": " + cudaGetErrorString(error));
}

/// Enqueues the writing of zeros to `count` elements.
template <class T>
void set_zero(const char* what, T* elements, std::size_t count, cudaStream_t stream) {
  check(cudaMemsetAsync(elements, 0, count * sizeof(T), stream), what);
}

/// Threads per block of kernels that use one thread per item.
inline constexpr unsigned kThreads = 256;

/// For __launch_bounds__: `wanted` blocks of `threads` threads on a multiprocessor, or as many as
/// it can hold: 1,024 threads with compute capability 7.5, 1,536 with 8.6, 8.9 and 12, else 2,048.
constexpr unsigned blocks_at_once(unsigned wanted, unsigned threads) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ < 800
  const unsigned held = 1024;
#elif defined(__CUDA_ARCH__) && \
    (__CUDA_ARCH__ == 860 || __CUDA_ARCH__ == 890 || __CUDA_ARCH__ >= 1200)
  const unsigned held = 1536;
#else
  const unsigned held = 2048;
#endif
  return wanted * threads <= held ? wanted : held / threads;
}

/// Number of blocks of kThreads threads that covers `items`, which must be below 2^39.
inline unsigned blocks_for(std::uint64_t items) {
  return static_cast<unsigned>((items + kThreads - 1) / kThreads);
}

/// Size of a launch: number of blocks, threads per block, and bytes of dynamic shared memory.
struct Blocks {
  unsigned count, threads;
  std::size_t shared_bytes;
  Blocks(unsigned count_, unsigned threads_ = kThreads, std::size_t shared_bytes_ = 0)
      : count(count_), threads(threads_), shared_bytes(shared_bytes_) {}
};

/// Enqueues a kernel in `stream`; `arguments` are passed by value.
template <class... Parameters, class... Arguments>
void launch(const char* what, void (*kernel)(Parameters...), Blocks blocks, cudaStream_t stream,
            Arguments... arguments) {
  cudaLaunchConfig_t config{};
  config.gridDim = dim3(blocks.count);
  config.blockDim = dim3(blocks.threads);
  config.dynamicSmemBytes = blocks.shared_bytes;
  if (blocks.shared_bytes > 0)
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize,
                               static_cast<int>(blocks.shared_bytes)),
          what);
  config.stream = stream;
  check(cudaLaunchKernelEx(&config, kernel, Parameters(arguments)...), what);
}

template <class Count, class Work>
__global__ void __launch_bounds__(kThreads) run_for_each(Count count, Work work) {
  const Count i = Count{blockIdx.x} * kThreads + threadIdx.x;
  if (i < count) work(i);
}

/// Enqueues work(i) for all i < `count`, with a thread each. `work` is a __device__ lambda that
/// captures by value.
template <class Count, class Work>
void for_each_item(const char* what, Count count, cudaStream_t stream, const Work& work) {
  if (count > 0) launch(what, run_for_each<Count, Work>, blocks_for(count), stream, count, work);
}

}  // namespace qs::cuda
