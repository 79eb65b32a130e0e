// SPDX-License-Identifier: MIT
//
// Replaces CUDA's header of the same name, so that g++ compiles src/raster/cuda/*.cu and the tests
// run the backend's kernels and host code on machines without a GPU. It emulates one GPU with
// kTotalBytes of memory. Streams execute everything immediately. Blocks run one after the other;
// the threads of a block are fibers, which switch at barriers of the block and at exchanges between
// the 32 threads of a warp. Only the part of the CUDA API that the backend uses is implemented.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <vector>

#define __global__
#define __device__
#define __forceinline__ inline
#define __host__
#define __shared__ static
#define __launch_bounds__(...)

struct dim3 {
  unsigned x = 1, y = 1, z = 1;
  dim3(unsigned x_ = 1) : x(x_) {}
};
struct uint2 {
  std::uint32_t x, y;
};
struct alignas(16) uint4 {
  std::uint32_t x, y, z, w;
};
struct float2 {
  float x, y;
};
struct alignas(16) float4 {
  float x, y, z, w;
};

// ---- inside kernels -----------------------------------------------------------------------------
namespace emulator {

inline constexpr std::size_t kTotalBytes = std::size_t{4} << 30;
inline std::size_t total_bytes = kTotalBytes;  ///< smaller in tests of a small GPU
inline constexpr int kMultiprocessors = 8;
inline int multiprocessors = kMultiprocessors;
inline int captured_graphs = 0;            ///< that were not destroyed
inline bool fails_to_instantiate = false;  ///< the next graphs

inline constexpr unsigned kWarpSize = 32;

/// The order in which blocks and threads run: 0 is ascending, every other seed gives another order.
/// On a GPU the order is arbitrary.
inline unsigned run_order = 0;
/// The indices of a launch's blocks by run_order.
std::vector<unsigned> ordered_blocks(unsigned blocks);

/// Runs `thread` as every thread of one block.
void run_block(unsigned threads, const std::function<void()>& thread);
/// Waits for all threads of the block that have not ended. Returns the sum of their values.
int barrier(int value);
/// Waits for all threads of the warp. Returns their values, by lane.
const std::array<std::uint64_t, kWarpSize>& warp_exchange(std::uint64_t value);

inline std::size_t used_bytes = 0;
inline std::size_t uploaded_bytes = 0;         ///< copied to the GPU so far
inline const void* memory_of_gpu_1 = nullptr;  ///< an address that another GPU has

inline std::vector<uint4> dynamic_shared;  // of the running kernel

}  // namespace emulator

inline dim3 threadIdx, blockIdx, blockDim, gridDim;

inline void __threadfence() {}
inline void __syncthreads() { emulator::barrier(0); }
inline int __syncthreads_count(int predicate) { return emulator::barrier(predicate != 0 ? 1 : 0); }

template <class T>
T atomicAdd(T* address, T value) {
  const T old = *address;
  *address += value;
  return old;
}
inline std::uint32_t atomicAdd(std::uint32_t* address, int value) {
  return atomicAdd(address, static_cast<std::uint32_t>(value));
}
inline std::uint32_t atomicMax(std::uint32_t* address, std::uint32_t value) {
  const std::uint32_t old = *address;
  *address = std::max(old, value);
  return old;
}
template <class T>
T atomicOr(T* address, T value) {
  const T old = *address;
  *address = old | value;
  return old;
}
inline std::uint32_t atomicMin(std::uint32_t* address, std::uint32_t value) {
  const std::uint32_t old = *address;
  *address = std::min(old, value);
  return old;
}
inline std::uint32_t atomicCAS(std::uint32_t* address, std::uint32_t expected,
                               std::uint32_t value) {
  const std::uint32_t old = *address;
  if (old == expected) *address = value;
  return old;
}
inline std::uint32_t __float_as_uint(float value) {
  std::uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}
inline float __uint_as_float(std::uint32_t bits) {
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}
inline int __popc(unsigned bits) { return std::popcount(bits); }
inline int __ffs(int bits) { return bits == 0 ? 0 : std::countr_zero(unsigned(bits)) + 1; }
using std::max;
using std::min;

// Exchanges between the threads of a warp. All 32 threads must call them.
inline void __syncwarp() { emulator::warp_exchange(0); }
inline unsigned __ballot_sync(unsigned, int predicate) {
  unsigned mask = 0;
  const auto& values = emulator::warp_exchange(predicate != 0);
  for (unsigned lane = 0; lane < emulator::kWarpSize; ++lane)
    mask |= unsigned(values[lane]) << lane;
  return mask;
}
inline int __any_sync(unsigned mask, int predicate) { return __ballot_sync(mask, predicate) != 0; }
template <class T>
T __shfl_sync(unsigned, T value, unsigned lane) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof value);
  bits = emulator::warp_exchange(bits)[lane % emulator::kWarpSize];
  std::memcpy(&value, &bits, sizeof value);
  return value;
}
inline unsigned __match_any_sync(unsigned, unsigned value) {
  unsigned mask = 0;
  const auto& values = emulator::warp_exchange(value);
  for (unsigned lane = 0; lane < emulator::kWarpSize; ++lane) {
    mask |= unsigned(values[lane] == value) << lane;
  }
  return mask;
}
template <class T>
T __shfl_up_sync(unsigned mask, T value, unsigned distance) {
  const unsigned lane = threadIdx.x % emulator::kWarpSize;
  return __shfl_sync(mask, value, lane >= distance ? lane - distance : lane);
}

template <class T>
T __shfl_xor_sync(unsigned mask, T value, unsigned difference) {
  return __shfl_sync(mask, value, (threadIdx.x % emulator::kWarpSize) ^ difference);
}

// ---- the runtime -----------------------------------------------------------------------------
enum cudaError_t {
  cudaSuccess = 0,
  cudaErrorMemoryAllocation = 2,
  cudaErrorInsufficientDriver = 35,
  cudaErrorInvalidDeviceFunction = 98,
  cudaErrorNoDevice = 100,
  cudaErrorNoKernelImageForDevice = 209
};
enum cudaMemcpyKind { cudaMemcpyHostToDevice, cudaMemcpyDeviceToHost, cudaMemcpyDeviceToDevice };
enum { cudaStreamNonBlocking = 1 };
using cudaStream_t = void*;
using cudaSurfaceObject_t = unsigned long long;
struct cudaExtent {
  std::size_t width, height, depth;
};
using cudaEvent_t = void*;

inline const char* cudaGetErrorString(cudaError_t error) {
  return error == cudaErrorMemoryAllocation ? "out of memory" : "an emulated error";
}
inline cudaError_t cudaGetLastError() { return cudaSuccess; }
inline cudaError_t cudaSetDevice(int) { return cudaSuccess; }
inline cudaError_t cudaGetDevice(int* device) { return *device = 0, cudaSuccess; }
inline cudaError_t cudaGetDeviceCount(int* count) { return *count = 2, cudaSuccess; }
inline cudaError_t cudaDeviceGetPCIBusId(char*, int, int) { return cudaErrorInvalidDeviceFunction; }
inline cudaError_t cudaDriverGetVersion(int* version) { return *version = 13000, cudaSuccess; }
inline cudaError_t cudaRuntimeGetVersion(int* version) { return *version = 13000, cudaSuccess; }

struct cudaDeviceProp {
  char name[256];
  std::size_t totalGlobalMem;
  int major, minor;
};
inline cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int) {
  *properties = {"emulator", emulator::total_bytes, 9, 0};
  return cudaSuccess;
}
struct cudaFuncAttributes {};
enum cudaDeviceAttr { cudaDevAttrMaxSharedMemoryPerBlockOptin, cudaDevAttrMultiProcessorCount };
/// Little shared memory, so that tests reach the limit.
inline cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr which, int) {
  *value = which == cudaDevAttrMultiProcessorCount ? emulator::multiprocessors : 68 << 10;
  return cudaSuccess;
}
enum { cudaFuncAttributeMaxDynamicSharedMemorySize = 8 };
template <class Kernel>
cudaError_t cudaFuncSetAttribute(Kernel, int, int) {
  return cudaSuccess;
}
inline cudaError_t cudaFuncGetAttributes(cudaFuncAttributes*, void (*)()) { return cudaSuccess; }

inline cudaError_t cudaMemGetInfo(std::size_t* free, std::size_t* total) {
  *free = emulator::total_bytes - std::min(emulator::used_bytes, emulator::total_bytes);
  *total = emulator::total_bytes;
  return cudaSuccess;
}

/// Every allocation is aligned to 256 bytes, as CUDA promises, preceded by its size, and filled
/// with 0xff, which no kernel should read.
template <class T>
cudaError_t cudaMalloc(T** pointer, std::size_t bytes) {
  constexpr std::size_t kHeader = 256;
  if (emulator::used_bytes + bytes > emulator::total_bytes) return cudaErrorMemoryAllocation;
  const std::size_t whole = (kHeader + bytes + kHeader - 1) / kHeader * kHeader;
  auto* memory = static_cast<char*>(std::aligned_alloc(kHeader, whole));
  std::memcpy(memory, &bytes, sizeof bytes);
  std::memset(memory + kHeader, 0xff, bytes);
  emulator::used_bytes += bytes;
  *pointer = reinterpret_cast<T*>(memory + kHeader);
  return cudaSuccess;
}
inline cudaError_t cudaFree(void* pointer) {
  if (pointer == nullptr) return cudaSuccess;
  char* memory = static_cast<char*>(pointer) - 256;
  std::size_t bytes;
  std::memcpy(&bytes, memory, sizeof bytes);
  emulator::used_bytes -= bytes;
  std::free(memory);
  return cudaSuccess;
}
inline cudaError_t cudaMallocAsync(void** pointer, std::size_t bytes, void*) {
  return cudaMalloc(pointer, bytes);
}
inline cudaError_t cudaFreeAsync(void* pointer, void*) { return cudaFree(pointer); }

enum cudaMemoryType { cudaMemoryTypeDevice = 2 };
struct cudaPointerAttributes {
  cudaMemoryType type;
  int device;
  void* devicePointer;
};
/// The GPU reads all memory of the host.
inline cudaError_t cudaPointerGetAttributes(cudaPointerAttributes* attributes,
                                            const void* pointer) {
  const int device = pointer == emulator::memory_of_gpu_1 ? 1 : 0;
  *attributes = {cudaMemoryTypeDevice, device, const_cast<void*>(pointer)};
  return cudaSuccess;
}
template <class T>
cudaError_t cudaMallocHost(T** pointer, std::size_t bytes) {
  *pointer = static_cast<T*>(std::malloc(bytes));
  return cudaSuccess;
}
inline cudaError_t cudaFreeHost(void* pointer) { return std::free(pointer), cudaSuccess; }
inline cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t bytes,
                                   cudaMemcpyKind kind, cudaStream_t) {
  if (kind == cudaMemcpyHostToDevice) emulator::uploaded_bytes += bytes;
  return std::memcpy(to, from, bytes), cudaSuccess;
}
inline cudaError_t cudaMemsetAsync(void* to, int value, std::size_t bytes, cudaStream_t) {
  return std::memset(to, value, bytes), cudaSuccess;
}

inline cudaError_t cudaDeviceGetStreamPriorityRange(int*, int*) { return cudaSuccess; }
inline cudaError_t cudaStreamCreateWithPriority(cudaStream_t*, unsigned, int) {
  return cudaSuccess;
}
inline cudaError_t cudaStreamWaitEvent(cudaStream_t, cudaEvent_t, unsigned = 0) {
  return cudaSuccess;
}
inline cudaError_t cudaStreamDestroy(cudaStream_t) { return cudaSuccess; }
inline cudaError_t cudaStreamSynchronize(cudaStream_t) { return cudaSuccess; }
inline cudaError_t cudaEventCreate(cudaEvent_t*) { return cudaSuccess; }
enum { cudaEventDefault = 0, cudaEventDisableTiming = 2 };
inline cudaError_t cudaEventCreateWithFlags(cudaEvent_t*, unsigned) { return cudaSuccess; }
inline cudaError_t cudaEventDestroy(cudaEvent_t) { return cudaSuccess; }
inline cudaError_t cudaEventRecord(cudaEvent_t, cudaStream_t) { return cudaSuccess; }
inline cudaError_t cudaEventSynchronize(cudaEvent_t) { return cudaSuccess; }
inline cudaError_t cudaEventElapsedTime(float* ms, cudaEvent_t, cudaEvent_t) {
  return *ms = 1, cudaSuccess;
}

// Captured work has been executed already, so launching a graph does nothing.
using cudaGraph_t = void*;
using cudaGraphExec_t = void*;
enum cudaStreamCaptureMode { cudaStreamCaptureModeThreadLocal };
struct cudaGraphExecUpdateResultInfo {};
inline cudaError_t cudaStreamBeginCapture(cudaStream_t, cudaStreamCaptureMode) {
  return cudaSuccess;
}
inline cudaError_t cudaStreamEndCapture(cudaStream_t, cudaGraph_t* graph) {
  ++emulator::captured_graphs;
  return *graph = graph, cudaSuccess;
}
enum { cudaGraphInstantiateFlagUseNodePriority = 8 };
inline cudaError_t cudaGraphInstantiate(cudaGraphExec_t* exec, cudaGraph_t graph, unsigned) {
  if (emulator::fails_to_instantiate) return cudaErrorMemoryAllocation;
  return *exec = graph, cudaSuccess;
}
inline cudaError_t cudaGraphExecUpdate(cudaGraphExec_t, cudaGraph_t,
                                       cudaGraphExecUpdateResultInfo*) {
  return cudaSuccess;
}
inline cudaError_t cudaGraphUpload(cudaGraphExec_t, cudaStream_t) { return cudaSuccess; }
inline cudaError_t cudaGraphLaunch(cudaGraphExec_t, cudaStream_t) { return cudaSuccess; }
inline cudaError_t cudaGraphDestroy(cudaGraph_t) {
  return --emulator::captured_graphs, cudaSuccess;
}
inline cudaError_t cudaGraphExecDestroy(cudaGraphExec_t) { return cudaSuccess; }

struct cudaLaunchConfig_t {
  dim3 gridDim, blockDim;
  std::size_t dynamicSmemBytes = 0;
  cudaStream_t stream = nullptr;
};
template <class... Parameters, class... Arguments>
cudaError_t cudaLaunchKernelEx(const cudaLaunchConfig_t* config, void (*kernel)(Parameters...),
                               Arguments... arguments) {
  gridDim = config->gridDim;
  blockDim = config->blockDim;
  emulator::dynamic_shared.assign((config->dynamicSmemBytes + sizeof(uint4) - 1) / sizeof(uint4),
                                  uint4{});
  for (const unsigned index : emulator::ordered_blocks(gridDim.x)) {
    blockIdx.x = index;
    emulator::run_block(blockDim.x, [&] { kernel(arguments...); });
  }
  return cudaSuccess;
}
