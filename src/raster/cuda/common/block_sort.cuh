// SPDX-License-Identifier: MIT
//
// Sorts Gaussians by depth, then by index in the file, in the shared memory of a block. Their order
// before is arbitrary, so the order after must be total.
#pragma once

#include "raster/cuda/common/warp.cuh"

namespace qs::cuda {

/// A Gaussian to sort.
struct SortEntry {
  std::uint32_t depth_key, place;  ///< place: the Gaussian's index in file_indices
};

/// Entries are sorted by depth, then by index in the file.
struct EntryOrder {
  const std::uint32_t* file_indices;  ///< per place

  __device__ std::uint32_t file_index(SortEntry entry) const { return file_indices[entry.place]; }
  __device__ std::uint64_t key(SortEntry entry) const {
    return std::uint64_t{entry.depth_key} << 32 | file_index(entry);
  }
};

/// Blocks of a usual size can sort so many entries on every GPU.
inline constexpr std::uint32_t kUsualSort = 3072;
/// The most entries in shared memory: an index and a mark share 16 bits.
inline constexpr std::uint32_t kMostSort = 1u << 15;

/// Memory in which a block sorts: three arrays of `capacity` elements. AnyIndex: of an item.
template <class AnyIndex>
struct SortArrays {
  using Index = AnyIndex;

  std::uint32_t* values;  ///< depth keys, by index of the entry; later Gaussians, in order
  Index* order;           ///< indices of entries, in order
  Index* other;           ///< the order before a pass of the sort; later masks of tiles, in order

  static constexpr std::size_t bytes(std::uint32_t capacity) {
    return capacity * (sizeof(std::uint32_t) + 2 * sizeof(Index));
  }

  __device__ SortArrays(void* memory, std::uint32_t capacity)
      : values(static_cast<std::uint32_t*>(memory)),
        order(reinterpret_cast<Index*>(values + capacity)),
        other(order + capacity) {}
};

using SharedArrays = SortArrays<std::uint16_t>;  ///< in the dynamic shared memory of a block
using GlobalArrays = SortArrays<std::uint32_t>;  ///< in global memory, for more items

/// The part of a block's items that a warp processes, in order: [begin, end).
struct WarpPart {
  unsigned begin, end;

  /// Of `size` items, cut into `parts` for which the lengths are multiples of 32.
  __device__ WarpPart(unsigned size, unsigned part, unsigned parts) {
    const unsigned each = (size + parts * kWarp - 1) / (parts * kWarp) * kWarp;
    begin = min(part * each, size);
    end = min(begin + each, size);
  }
};

/// Sorts with the kBlock threads of a block, which call all functions together.
template <unsigned kBlock, class Arrays = SharedArrays>
class BlockSort {
 public:
  __device__ BlockSort(Arrays& arrays, const SortEntry* entries, EntryOrder entry_order,
                       unsigned size)
      : arrays_(arrays),
        entries_(entries),
        entry_order_(entry_order),
        size_(size),
        part_(size, threadIdx.x / kWarp, kWarps) {}

  /// Sets arrays.order to the indices of the entries by depth, then by index in the file.
  __device__ void sort() {
    const auto depth_key = [](SortEntry entry) { return entry.depth_key; };
    const auto all = [](int bits) { return (bits + kDigitBits - 1) / kDigitBits; };
    begin_with(depth_key);
    const bool is_sorted = sort_by_values([](int bits) { return bits <= kFewBits ? 2 : 3; });
    if (!is_sorted && !exchange_neighbours()) sort_by_values(all);
    if (sort_few_ties() || sort_ties()) return;
    begin_with([this](SortEntry entry) { return entry_order_.file_index(entry); });
    sort_by_values(all);
    load(depth_key);
    sort_by_values(all);
  }

 private:
  using Index = typename Arrays::Index;

  static constexpr int kDigitBits = 8;
  /// Depths that differ in so many bits at most need two passes; exchanges do the rest.
  static constexpr int kFewBits = 20;
  static constexpr unsigned kDigits = 1u << kDigitBits;
  static constexpr unsigned kWarps = kBlock / kWarp;
  static constexpr unsigned kOwnDigits = kBlock < kDigits ? kDigits / kBlock : 1;

  template <class ValueOf>
  __device__ void load(const ValueOf& value_of) {
    __syncthreads();
    for (unsigned i = threadIdx.x; i < size_; i += kBlock)
      arrays_.values[i] = value_of(entries_[i]);
    __syncthreads();
  }

  template <class ValueOf>
  __device__ void begin_with(const ValueOf& value_of) {
    load(value_of);
    for (unsigned i = threadIdx.x; i < size_; i += kBlock) arrays_.order[i] = static_cast<Index>(i);
    __syncthreads();
  }

  /// The largest of the block's values.
  __device__ std::uint32_t largest(std::uint32_t value) {
    __shared__ std::uint32_t of_warps[kWarps];
    value = largest_of_warp(value);
    if (lane_index() == 0) of_warps[threadIdx.x / kWarp] = value;
    __syncthreads();
    for (const std::uint32_t other : of_warps) value = max(value, other);
    __syncthreads();
    return value;
  }

  /// Sorts arrays.order by the highest digits of the b bits in which the values of its elements
  /// differ; passes_of(b) is the number of digits. Elements with equal digits keep their order. A
  /// radix sort from the lowest of these digits. Returns true if these are all digits.
  template <class PassesOf>
  __device__ bool sort_by_values(const PassesOf& passes_of) {
    std::uint32_t most = 0, inverse_of_least = 0;
    for (unsigned i = threadIdx.x; i < size_; i += kBlock) {
      most = max(most, arrays_.values[i]);
      inverse_of_least = max(inverse_of_least, ~arrays_.values[i]);
    }
    const std::uint32_t least = ~largest(inverse_of_least), range = largest(most) - least;
    int bits = 0;
    while (bits < 32 && range >> bits != 0) ++bits;
    const int shift_of_lowest = max(bits - passes_of(bits) * kDigitBits, 0);
    for (int shift = shift_of_lowest; shift < bits; shift += kDigitBits)
      sort_by_digit(least, shift);
    return shift_of_lowest == 0;
  }

  __device__ void sort_by_digit(std::uint32_t least, int shift) {
    // 16-bit counts of two warps share a word, because atomicAdd has no such form.
    constexpr unsigned kShare = sizeof(std::uint32_t) / sizeof(Index);
    __shared__ std::uint32_t counts[kWarps / kShare][kDigits];
    const unsigned thread = threadIdx.x, warp = thread / kWarp;
    const auto count_of = [&](unsigned w, unsigned digit) -> Index& {
      return reinterpret_cast<Index*>(&counts[w / kShare][digit])[w % kShare];
    };
    const auto digit_of_item = [&](unsigned item) {
      return (arrays_.values[item] - least) >> shift & (kDigits - 1);
    };
    for (unsigned i = thread; i < kWarps / kShare * kDigits; i += kBlock) (&counts[0][0])[i] = 0;
    __syncthreads();
    for (unsigned i = part_.begin + lane_index(); i < part_.end; i += kWarp) {
      const unsigned digit = digit_of_item(arrays_.order[i]);
      atomicAdd(&counts[warp / kShare][digit], 1u << 16 * (warp % kShare));
    }
    __syncthreads();
    std::uint32_t sum = 0;
    const unsigned own = thread * kOwnDigits;
    for (unsigned d = own; d < own + kOwnDigits && d < kDigits; ++d)
#pragma unroll
      for (unsigned w = 0; w < kWarps; ++w) sum += count_of(w, d);
    std::uint32_t before = sum_of_block<kBlock>(sum).before;
    for (unsigned d = own; d < own + kOwnDigits && d < kDigits; ++d) {
#pragma unroll
      for (unsigned w = 0; w < kWarps; ++w) {
        const std::uint32_t count = count_of(w, d);
        count_of(w, d) = static_cast<Index>(before);
        before += count;
      }
    }
    __syncthreads();
    for (unsigned first = part_.begin; first < part_.end; first += kWarp) {
      const bool exists = first + lane_index() < part_.end;
      const Index item = exists ? arrays_.order[first + lane_index()] : 0;
      const unsigned digit = digit_of_item(item);
      const unsigned peers = peers_of<kDigitBits>(digit, exists);
      const unsigned below = __popc(peers & lanes_below());
      const unsigned begin = count_of(warp, digit);
      __syncwarp();
      if (exists && below == 0) count_of(warp, digit) = static_cast<Index>(begin + __popc(peers));
      __syncwarp();
      if (exists) arrays_.other[begin + below] = item;
    }
    swap_orders();
  }

  /// Makes the order that was written the current one.
  __device__ void swap_orders() {
    __syncthreads();
    Index* const written = arrays_.other;
    arrays_.other = arrays_.order;
    arrays_.order = written;
  }

  /// The depth of the entry at a place of the order.
  __device__ std::uint32_t depth_at(unsigned i) const { return arrays_.values[arrays_.order[i]]; }

  /// Sorts entries with equal depths by index in the file, a thread for each depth. Requires an
  /// order by depth. Returns false, with that order, if there are many of them.
  __device__ bool sort_few_ties() {
    constexpr unsigned kMostEqual = 16;
    __shared__ std::uint32_t found;
    if (threadIdx.x == 0) found = 0;
    __syncthreads();
    for (unsigned i = threadIdx.x; i - lane_index() < size_; i += kBlock) {
      const bool is_first = i + 1 < size_ && depth_at(i) == depth_at(i + 1) &&
                            (i == 0 || depth_at(i - 1) != depth_at(i));
      const std::uint32_t slot = reserve_slot(is_first, &found);
      if (is_first) arrays_.other[slot] = static_cast<Index>(i);
    }
    __syncthreads();
    bool are_few = found <= size_ / 8;
    for (unsigned k = threadIdx.x; k < found && are_few; k += kBlock) {
      const unsigned first = arrays_.other[k];
      unsigned end = first + 2;
      while (end < size_ && end - first <= kMostEqual && depth_at(end) == depth_at(first)) ++end;
      arrays_.other[found + k] = static_cast<Index>(end);
      are_few = end - first <= kMostEqual;
    }
    if (__syncthreads_count(!are_few) > 0) return false;
    const auto index_at = [&](unsigned i) {
      return entry_order_.file_index(entries_[arrays_.order[i]]);
    };
    for (unsigned k = threadIdx.x; k < found; k += kBlock) {
      const unsigned first = arrays_.other[k], end = arrays_.other[found + k];
      for (unsigned i = first + 1; i < end; ++i) {
        const std::uint32_t own = index_at(i);
        const Index item = arrays_.order[i];
        unsigned place = i;
        for (; place > first && index_at(place - 1) > own; --place)
          arrays_.order[place] = arrays_.order[place - 1];
        arrays_.order[place] = item;
      }
    }
    __syncthreads();
    return true;
  }

  /// Sorts entries with equal depths by index in the file. Requires an order by depth. Each entry
  /// is compared with all entries of its depth. Returns false if more than a few are equal; then
  /// the order is lost.
  __device__ bool sort_ties() {
    constexpr unsigned kMostEqual = 64;
    constexpr Index kFirst = Index{1} << (8 * sizeof(Index) - 1);  // marks the first of its depth
    for (unsigned i = threadIdx.x; i < size_; i += kBlock) {
      const Index item = arrays_.order[i];
      const bool is_first = i == 0 || depth_at(i - 1) != depth_at(i);
      arrays_.other[i] = static_cast<Index>(item | (is_first ? kFirst : 0));
    }
    swap_orders();
    load([this](SortEntry entry) { return entry_order_.file_index(entry); });
    const auto is_first = [&](unsigned i) { return (arrays_.order[i] & kFirst) != 0; };
    const auto index_of = [&](unsigned i) {
      return arrays_.values[static_cast<Index>(arrays_.order[i] & ~kFirst)];
    };
    bool are_few = true;
    for (unsigned i = threadIdx.x; i < size_; i += kBlock) {
      const std::uint32_t own = index_of(i);
      unsigned first = i, place = i, end = i + 1;
      for (; !is_first(first) && i - first < kMostEqual; --first)
        place -= index_of(first - 1) > own ? 1 : 0;
      for (; end < size_ && !is_first(end) && end - i < kMostEqual; ++end)
        place += index_of(end) < own ? 1 : 0;
      if (end - first < kMostEqual)
        arrays_.other[place] = static_cast<Index>(arrays_.order[i] & ~kFirst);
      else
        are_few = false;
    }
    swap_orders();
    return __syncthreads_count(!are_few) == 0;
  }

  /// Completes an order by depth in which few neighbours are swapped. Returns false if it needs
  /// more than a few rounds.
  __device__ bool exchange_neighbours() {
    constexpr int kRounds = 12;
    for (int round = 0; round < kRounds; ++round) {
      bool exchanged = false;
      for (unsigned odd = 1; odd <= 2; ++odd) {
        for (unsigned i = odd + 2 * threadIdx.x; i < size_; i += 2 * kBlock) {
          const Index front = arrays_.order[i - 1], back = arrays_.order[i];
          if (arrays_.values[front] <= arrays_.values[back]) continue;
          arrays_.order[i - 1] = back;
          arrays_.order[i] = front;
          exchanged = true;
        }
        __syncthreads();
      }
      if (__syncthreads_count(exchanged) == 0) return true;
    }
    return false;
  }

  Arrays& arrays_;
  const SortEntry* entries_;
  EntryOrder entry_order_;
  unsigned size_;
  WarpPart part_;
};

}  // namespace qs::cuda
