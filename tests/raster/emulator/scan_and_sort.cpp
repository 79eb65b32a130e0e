// SPDX-License-Identifier: MIT
//
// Replaces src/raster/cuda/common/scan_and_sort.cu, which needs CUB, by host code.
#include "raster/cuda/common/scan_and_sort.cuh"

#include <numeric>
#include <vector>

namespace qs::cuda {

void exclusive_sum(const std::uint32_t* counts, std::uint64_t* sums, std::uint32_t size,
                   DeviceBuffer<std::byte>&, cudaStream_t) {
  std::exclusive_scan(counts, counts + size, sums, std::uint64_t{0});
}

void SortBuffers::reserve(const char* what, std::uint32_t size) {
  constexpr std::uint64_t kPairBytes = 2 * (sizeof(std::uint64_t) + sizeof(std::uint32_t));
  require_memory(what, kPairBytes * size, kPairBytes * values.capacity());
  keys.reserve(what, size);
  values.reserve(what, size);
}

void sort_pairs(SortBuffers& buffers, std::uint32_t size, int key_bits, cudaStream_t) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> pairs(size);
  for (std::uint32_t i = 0; i < size; ++i)
    pairs[i] = {buffers.keys.data()[i], buffers.values.data()[i]};
  const std::uint64_t mask = key_bits == 64 ? ~0ull : (1ull << key_bits) - 1;
  std::stable_sort(pairs.begin(), pairs.end(), [mask](const auto& a, const auto& b) {
    return (a.first & mask) < (b.first & mask);
  });
  for (std::uint32_t i = 0; i < size; ++i) {
    buffers.keys.data()[i] = pairs[i].first;
    buffers.values.data()[i] = pairs[i].second;
  }
}

}  // namespace qs::cuda
