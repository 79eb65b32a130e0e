// SPDX-License-Identifier: MIT
//
// Prefix sum and sort, from CUB. Only one translation unit includes its headers, because they take
// longer to compile than all other code of the backend.
#pragma once

#include <cstddef>
#include <cstdint>

#include "raster/cuda/common/device_buffer.cuh"

namespace qs::cuda {

/// sums[i] = counts[0] + ... + counts[i - 1], in 64 bits; `counts` and `sums` have `size` elements.
void exclusive_sum(const std::uint32_t* counts, std::uint64_t* sums, std::uint32_t size,
                   DeviceBuffer<std::byte>& scratch, cudaStream_t stream);

/// Two buffers each for keys and values: every sorting pass moves them from one to the other.
struct SortBuffers {
  DeviceBuffer<std::uint64_t> keys, other_keys;
  DeviceBuffer<std::uint32_t> values, other_values;
  DeviceBuffer<std::byte> scratch;

  /// Makes room for `size` pairs and for sorting them. Throws Error(device) with the total size if
  /// memory is short.
  void reserve(const char* what, std::uint32_t size);
};

/// Sorts `size` pairs stably by the lowest `key_bits` bits of their keys. The result is in `keys`
/// and `values`.
void sort_pairs(SortBuffers& buffers, std::uint32_t size, int key_bits, cudaStream_t stream);

}  // namespace qs::cuda
