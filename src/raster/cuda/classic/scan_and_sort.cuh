// SPDX-License-Identifier: MIT
//
// The two parallel algorithms that come from CUB. Its headers are read by one translation unit
// only: they take longer to compile than everything else here together.
#pragma once

#include <cstddef>
#include <cstdint>

#include "raster/cuda/device_buffer.cuh"

namespace qs::cuda {

using Scratch = DeviceBuffer<std::byte>;

/// sums[i] = counts[0] + ... + counts[i - 1], in 64 bits; `counts` and `sums` have `size` elements.
void exclusive_sum(const std::uint32_t* counts, std::uint64_t* sums, std::uint32_t size,
                   Scratch& scratch, cudaStream_t stream);

/// Keys and values in two copies, between which sorting moves them back and forth.
struct SortBuffers {
  DeviceBuffer<std::uint64_t> keys, other_keys;
  DeviceBuffer<std::uint32_t> values, other_values;
  Scratch scratch;

  /// Room for `size` pairs and for sorting them; throws Error(device) with what all of it needs.
  void reserve(const char* what, std::uint32_t size);
};

/// Sorts `size` pairs stably by the lowest `key_bits` bits of their keys, into keys and values.
void sort_pairs(SortBuffers& buffers, std::uint32_t size, int key_bits, cudaStream_t stream);

}  // namespace qs::cuda
