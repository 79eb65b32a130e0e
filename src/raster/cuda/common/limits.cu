// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/common/block_sort.cuh"
#include "raster/cuda/common/check.cuh"
#include "raster/cuda/common/limits.cuh"

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
      std::clamp<std::size_t>(available / SharedArrays::bytes(1), kUsualSort, kMostSort));
}

void require_indexable(std::uint64_t tile_pairs) {
  if (tile_pairs <= kMaxPairs) return;
  throw Error(ErrorKind::device, "cuda: bin: this view lists " + std::to_string(tile_pairs) +
                                     " tile pairs, at most " + std::to_string(kMaxPairs) +
                                     " can be sorted");
}

}  // namespace qs::cuda
