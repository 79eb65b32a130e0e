// SPDX-License-Identifier: MIT
//
// A stable radix sort of keys with 32-bit values, one kernel per digit from the lowest: every block
// ranks its items, finds by decoupled look-back how many items with equal digits earlier blocks
// have, and scatters its items (Adinets and Merrill, Onesweep, 2022). Unlike CUB's, it reads the
// number of items on the device, so that the host does not have to wait for it.
#pragma once

#include <algorithm>

#include "raster/cuda/fast/warp.cuh"
#include "raster/kernel/hd.h"

namespace qs::cuda::fast {

inline constexpr unsigned kSortThreads = 512;
inline constexpr unsigned kPart = 8 * kSortThreads;  ///< items per block

/// Bits per digit and number of digits of a key.
template <class Key>
struct Radix;
template <>
struct Radix<std::uint32_t> {
  static constexpr int kBits = 9, kPasses = 4;
};
template <>
struct Radix<std::uint16_t> {
  static constexpr int kBits = 8, kPasses = 2;
};

template <class Key>
inline constexpr std::uint32_t kBins = 1u << Radix<Key>::kBits;

template <class Key>
QS_HD std::uint32_t digit_of(Key key, int pass) {
  return (std::uint32_t{key} >> (pass * Radix<Key>::kBits)) & (kBins<Key> - 1);
}

/// A number of items that only the device knows: *size, limited to `limit`.
struct DeviceCount {
  const std::uint32_t* size;  ///< null: exactly `limit`
  std::uint32_t limit;

  __device__ std::uint32_t get() const { return size == nullptr ? limit : min(*size, limit); }
  unsigned parts() const { return std::max(1u, (limit + kPart - 1) / kPart); }
};

/// The items of a key are [begin(), end). All zero: none. Stored inverted, so that atomicMax alone
/// computes it.
struct KeyRange {
  std::uint32_t not_begin, end;

  QS_HD std::uint32_t begin() const { return end == 0 ? 0 : ~not_begin; }
  QS_HD std::uint32_t size() const { return end - begin(); }
};

/// One pass of the sort. Passed to the kernel by value.
template <class Key>
struct SortPass {
  DeviceCount count;
  int pass;    ///< number of the digit, from the lowest
  bool drops;  ///< omit items whose key is kDroppedKey
  const Key* keys;
  const std::uint32_t* values;  ///< null: the value of an item is its index
  Key* sorted_keys;             ///< null: not needed
  std::uint32_t* sorted_values;
  KeyRange* ranges;  ///< per key, initially zero; only in the last pass, null: not needed
  const std::uint32_t* digit_counts;  ///< kBins: number of items with each digit
  volatile std::uint32_t* words;      ///< look-back, kBins per part, initially zero
};

inline constexpr std::uint32_t kDroppedKey = 0xffffffffu;

template <class Key>
void sort_pass(const SortPass<Key>& pass, cudaStream_t stream);

/// Counts the digits of all keys except kDroppedKey in counts[pass][digit], and adds the number of
/// these keys to *kept.
void count_digits(const std::uint32_t* keys, std::uint32_t size, std::uint32_t* counts,
                  std::uint32_t* kept, cudaStream_t stream);

}  // namespace qs::cuda::fast
