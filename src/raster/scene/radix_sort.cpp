// SPDX-License-Identifier: MIT
#include "raster/scene/radix_sort.h"

#include <bit>
#include <functional>
#include <utility>

#include "base/error.h"

namespace qs {
namespace {

/// Items [begin, end) of segment `i`, when `count` items are split into `segments`.
std::pair<std::size_t, std::size_t> segment(std::size_t i, std::size_t segments,
                                            std::size_t count) {
  return {count * i / segments, count * (i + 1) / segments};
}

}  // namespace

// Least significant digit first. Sorting key - range.low leaves fewer bits and so fewer passes.
// Every thread counts and then moves one segment of the items; the targets do not depend on the
// number of segments.
void radix_sort(SortItems& items, KeyRange range, ThreadPool& pool, const std::stop_token& stop) {
  constexpr int kMaxDigitBits = 11;
  if (items.keys.empty()) return;
  const auto bits = static_cast<int>(std::bit_width(range.high - range.low));
  const int passes = (bits + kMaxDigitBits - 1) / kMaxDigitBits;
  const int digit_bits = passes == 0 ? 0 : (bits + passes - 1) / passes;
  const std::size_t buckets = std::size_t{1} << digit_bits;
  const auto segments = static_cast<std::size_t>(pool.size());

  for (int pass = 0; pass < passes; ++pass) {
    if (stop.stop_requested()) throw Cancelled{};
    const auto digit = [&, smallest = range.low](std::uint32_t key) {
      return ((key - smallest) >> (pass * digit_bits)) & (buckets - 1);
    };
    // Count the digits of every segment.
    items.offsets.assign(segments * buckets, 0);
    const auto count = [&](std::size_t s, std::size_t, int) {
      std::uint32_t* counts = &items.offsets[s * buckets];
      const auto [begin, end] = segment(s, segments, items.keys.size());
      for (std::size_t i = begin; i < end; ++i) ++counts[digit(items.keys[i])];
    };
    const auto move = [&](std::size_t s, std::size_t, int) {
      std::uint32_t* offsets = &items.offsets[s * buckets];
      const auto [begin, end] = segment(s, segments, items.keys.size());
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t to = offsets[digit(items.keys[i])]++;
        items.other_keys[to] = items.keys[i];
        items.other_values[to] = items.values[i];
      }
    };
    pool.for_chunks(segments, 1, std::cref(count));
    // Turn the counts into the first targets, ordered by digit and then by segment.
    std::uint32_t sum = 0;
    for (std::size_t bucket = 0; bucket < buckets; ++bucket)
      for (std::size_t s = 0; s < segments; ++s)
        sum += std::exchange(items.offsets[s * buckets + bucket], sum);
    pool.for_chunks(segments, 1, std::cref(move));
    items.keys.swap(items.other_keys);
    items.values.swap(items.other_values);
  }
}

}  // namespace qs
