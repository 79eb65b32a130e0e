// SPDX-License-Identifier: MIT
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <cuda/std/functional>

#include "raster/cuda/common/scan_and_sort.cuh"

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

auto sort_call(cub::DoubleBuffer<std::uint64_t>& keys, cub::DoubleBuffer<std::uint32_t>& values,
               std::uint32_t size, int key_bits, cudaStream_t stream) {
  return [=, &keys, &values](void* scratch, std::size_t& bytes) {
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

void SortBuffers::reserve(const char* what, std::uint32_t size) {
  if (size <= other_values.capacity()) return;  // other_values is reserved last
  constexpr int kKeyBits = 64;
  cub::DoubleBuffer<std::uint64_t> no_keys;
  cub::DoubleBuffer<std::uint32_t> no_values;
  const auto bytes_for = [&](std::uint32_t room) {
    constexpr std::uint64_t kPairBytes = 2 * (sizeof(std::uint64_t) + sizeof(std::uint32_t));
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

void sort_pairs(SortBuffers& buffers, std::uint32_t size, int key_bits, cudaStream_t stream) {
  cub::DoubleBuffer keys(buffers.keys.data(), buffers.other_keys.data());
  cub::DoubleBuffer values(buffers.values.data(), buffers.other_values.data());
  run(sort_call(keys, values, size, key_bits, stream), buffers.scratch, "sort");
  if (keys.selector != 0) buffers.keys.swap(buffers.other_keys);
  if (values.selector != 0) buffers.values.swap(buffers.other_values);
}

}  // namespace qs::cuda
