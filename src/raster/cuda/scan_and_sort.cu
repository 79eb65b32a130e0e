// SPDX-License-Identifier: MIT
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <cuda/std/functional>

#include "raster/cuda/scan_and_sort.cuh"

namespace qs::cuda {
namespace {

/// CUB algorithms are called twice: the first call returns the scratch size that the second needs.
template <class Call>
std::size_t scratch_bytes(const Call& call, const char* what) {
  std::size_t bytes = 0;
  check(call(nullptr, bytes), what);
  return bytes;
}

template <class Call>
void run(const Call& call, DeviceBuffer<std::byte>& scratch, const char* what) {
  std::size_t bytes = scratch_bytes(call, what);
  scratch.reserve(what, bytes);
  check(call(scratch.data(), bytes), what);
}

/// CUB's policy of sorting with blocks of 2,048 pairs. The usual blocks of 8,832 pairs leave most
/// of a large GPU idle while it sorts some hundred thousand pairs.
template <class Key>
struct SmallBlocks {
  using Usual = cub::detail::radix::policy_hub<Key, std::uint32_t, std::uint32_t>;
  struct MaxPolicy : cub::ChainedPolicy<500, MaxPolicy, MaxPolicy>,
                     Usual::template OnesweepSmallKeyTunedPolicy<
                         cub::detail::radix::sm90_small_key_tuning<sizeof(Key), 4, 4>> {
    static constexpr int kThreadsPerBlock = 256, kPairsPerThread = 8, kDigitBits = 8;
    using OnesweepPolicy = cub::AgentRadixSortOnesweepPolicy<
        kThreadsPerBlock, kPairsPerThread, Key, 1, cub::RADIX_RANK_MATCH_EARLY_COUNTS_ANY,
        cub::BLOCK_SCAN_RAKING_MEMOIZE, cub::RADIX_SORT_STORE_DIRECT, kDigitBits>;
  };
};

/// Sorts of fewer pairs use small blocks.
constexpr std::uint32_t kManyPairs = 2'000'000;

template <class Key>
auto sort_call(cub::DoubleBuffer<Key>& keys, cub::DoubleBuffer<std::uint32_t>& values,
               std::uint32_t size, int key_bits, cudaStream_t stream) {
  return [=, &keys, &values](void* scratch, std::size_t& bytes) {
    if constexpr (sizeof(Key) == 4) {
      if (size < kManyPairs) {
        return cub::DispatchRadixSort<cub::SortOrder::Ascending, Key, std::uint32_t, std::uint32_t,
                                      cub::detail::identity_decomposer_t,
                                      SmallBlocks<Key>>::Dispatch(scratch, bytes, keys, values,
                                                                  size, 0, key_bits, true, stream);
      }
    }
    return cub::DeviceRadixSort::SortPairs(scratch, bytes, keys, values, size, 0, key_bits, stream);
  };
}

}  // namespace

void exclusive_sum(const std::uint32_t* counts, std::uint64_t* sums, std::uint32_t size,
                   DeviceBuffer<std::byte>& scratch, cudaStream_t stream) {
  const auto call = [&](void* memory, std::size_t& bytes) {
    // CUB accumulates in the type of the initial value.
    return cub::DeviceScan::ExclusiveScan(memory, bytes, counts, sums, ::cuda::std::plus<>{},
                                          std::uint64_t{0}, size, stream);
  };
  run(call, scratch, "scan");
}

template <class Key>
void SortBuffers<Key>::reserve(const char* what, std::uint32_t size) {
  if (size <= other_values.capacity()) return;  // other_values is reserved last
  constexpr int kKeyBits = 8 * sizeof(Key);
  cub::DoubleBuffer<Key> no_keys;
  cub::DoubleBuffer<std::uint32_t> no_values;
  const auto bytes_for = [&](std::uint32_t room) {
    constexpr std::uint64_t kPairBytes = 2 * (sizeof(Key) + sizeof(std::uint32_t));
    return kPairBytes * room +
           scratch_bytes(sort_call(no_keys, no_values, room, kKeyBits, nullptr), "sort");
  };
  const std::uint64_t held =
      keys.bytes() + other_keys.bytes() + values.bytes() + other_values.bytes() + scratch.bytes();
  require_memory(what, bytes_for(size), held);
  const std::uint32_t room = with_headroom(size, UINT32_MAX, held, bytes_for);
  for (auto* buffer : {&keys, &other_keys}) buffer->release();
  for (auto* buffer : {&values, &other_values}) buffer->release();
  keys.reserve(what, room);
  other_keys.reserve(what, room);
  values.reserve(what, room);
  scratch.reserve(what,
                  scratch_bytes(sort_call(no_keys, no_values, room, kKeyBits, nullptr), "sort"));
  other_values.reserve(what, room);
}

template <class Key>
void sort_pairs(SortBuffers<Key>& buffers, std::uint32_t size, int key_bits, cudaStream_t stream) {
  cub::DoubleBuffer keys(buffers.keys.data(), buffers.other_keys.data());
  cub::DoubleBuffer values(buffers.values.data(), buffers.other_values.data());
  run(sort_call(keys, values, size, key_bits, stream), buffers.scratch, "sort");
  if (keys.selector != 0) buffers.keys.swap(buffers.other_keys);
  if (values.selector != 0) buffers.values.swap(buffers.other_values);
}

template struct SortBuffers<std::uint32_t>;
template struct SortBuffers<std::uint64_t>;
template void sort_pairs(SortBuffers<std::uint32_t>&, std::uint32_t, int, cudaStream_t);
template void sort_pairs(SortBuffers<std::uint64_t>&, std::uint32_t, int, cudaStream_t);

}  // namespace qs::cuda
