// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/common/block_sort.cuh"
#include "raster/cuda/common/check.cuh"
#include "raster/cuda/common/device_limits.cuh"

namespace qs::cuda {
namespace {

int attribute(cudaDeviceAttr which) {
  int device = 0, value = 0;
  check(cudaGetDevice(&device), "cudaGetDevice");
  check(cudaDeviceGetAttribute(&value, which, device), "cudaDeviceGetAttribute");
  return value;
}

}  // namespace

unsigned multiprocessors() {
  return static_cast<unsigned>(std::max(attribute(cudaDevAttrMultiProcessorCount), 1));
}

std::uint32_t most_in_shared_memory() {
  constexpr std::size_t kStaticBytes = 36 << 10;  // of the kernels that sort, rounded up
  const int bytes = attribute(cudaDevAttrMaxSharedMemoryPerBlockOptin);
  const std::size_t available = static_cast<std::size_t>(bytes) - kStaticBytes;
  return static_cast<std::uint32_t>(
      std::max<std::size_t>(available / SharedArrays::bytes(1), kUsualSort));
}

}  // namespace qs::cuda
