// SPDX-License-Identifier: MIT
//
// A stable sort of keys with 32-bit values, digit by digit from the lowest, one kernel per digit:
// every block ranks its part, learns by decoupled look-back how many equal digits lie before it,
// and writes its items where they belong (Adinets and Merrill, Onesweep, 2022). Unlike CUB's, it
// takes the number of items from the device, so that no frame waits for the host.
#pragma once

#include <algorithm>

#include "raster/cuda/fast/warp.cuh"
#include "raster/kernel/hd.h"

namespace qs::cuda::fast {

inline constexpr unsigned kSortThreads = 512;
inline constexpr unsigned kPart = 8 * kSortThreads;  ///< items of a block

/// How keys are cut into digits.
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

/// Items that are known on the device only: *size of them, but never more than the limit.
struct DeviceCount {
  const std::uint32_t* size;  ///< null: the limit
  std::uint32_t limit;

  __device__ std::uint32_t get() const { return size == nullptr ? limit : min(*size, limit); }
  unsigned parts() const { return std::max(1u, (limit + kPart - 1) / kPart); }
};

/// Where the items of a key lie, [begin(), end); all zero: nowhere. Made by atomicMax alone.
struct KeyRange {
  std::uint32_t not_begin, end;

  QS_HD std::uint32_t begin() const { return end == 0 ? 0 : ~not_begin; }
  QS_HD std::uint32_t size() const { return end - begin(); }
};

/// One pass. Passed to the kernel by value.
template <class Key>
struct SortPass {
  DeviceCount count;
  int pass;    ///< number of the digit, from the lowest
  bool drops;  ///< leave items out whose key is kDroppedKey
  const Key* keys;
  const std::uint32_t* values;  ///< null: the value of an item is its index
  Key* sorted_keys;             ///< null: not wanted
  std::uint32_t* sorted_values;
  KeyRange* ranges;  ///< of every key, zero before; null: not wanted; last pass only
  const std::uint32_t* digit_counts;  ///< kBins: how many items have each digit
  volatile std::uint32_t* words;      ///< look-back, kBins per part, zero
};

inline constexpr std::uint32_t kDroppedKey = 0xffffffffu;

template <class Key>
void sort_pass(const SortPass<Key>& pass, cudaStream_t stream);

/// Adds to counts[pass][digit] for every digit of every key but kDroppedKey, and their number to
/// *kept.
void count_digits(const std::uint32_t* keys, std::uint32_t size, std::uint32_t* counts,
                  std::uint32_t* kept, cudaStream_t stream);

}  // namespace qs::cuda::fast
