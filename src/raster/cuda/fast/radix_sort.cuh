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

/// How keys are cut into digits and items into the parts of blocks.
template <class Key>
struct Radix;
template <>
struct Radix<std::uint32_t> {
  static constexpr int kBits = 10, kPasses = 3, kItems = 8;  // items of a thread
};
template <>
struct Radix<std::uint16_t> {
  static constexpr int kBits = 8, kPasses = 2, kItems = 16;
};

template <class Key>
inline constexpr std::uint32_t kBins = 1u << Radix<Key>::kBits;
template <class Key>
inline constexpr std::uint32_t kPart = kThreads* Radix<Key>::kItems;  ///< items of a block

template <class Key>
QS_HD std::uint32_t digit_of(Key key, int pass) {
  return (std::uint32_t{key} >> (pass * Radix<Key>::kBits)) & (kBins<Key> - 1);
}

/// Items that are known on the device only: *size of them, but never more than the limit.
struct DeviceCount {
  const std::uint32_t* size;  ///< null: the limit
  std::uint32_t limit;

  __device__ std::uint32_t get() const { return size == nullptr ? limit : min(*size, limit); }
  template <class Key>
  unsigned parts() const {
    return std::max(1u, (limit + kPart<Key> - 1) / kPart<Key>);
  }
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
