// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/sort.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace qs::cpu::fast {
namespace {

/// Items [begin, end) of segment `i` when `count` items are cut into `segments`.
std::pair<std::size_t, std::size_t> segment(std::size_t i, std::size_t segments,
                                            std::size_t count) {
  return {count * i / segments, count * (i + 1) / segments};
}

/// Copies depth bits and slots without the gaps of Visible. Returns the range of the bits.
std::pair<std::uint32_t, std::uint32_t> gather(const FrameContext& frame,
                                               const VisibleSlots& visible, DepthOrder& order) {
  const std::size_t chunks = visible.chunk_counts.size();
  std::vector<std::size_t> begins(chunks);
  std::exclusive_scan(visible.chunk_counts.begin(), visible.chunk_counts.end(), begins.begin(),
                      std::size_t{0});
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ranges(
      static_cast<std::size_t>(frame.pool.size()), {~0u, 0u});
  frame.for_chunks(chunks, 8, [&](std::size_t begin, std::size_t end, int worker) {
    auto [low, high] = ranges[static_cast<std::size_t>(worker)];
    for (std::size_t chunk = begin; chunk < end; ++chunk) {
      std::size_t to = begins[chunk];
      auto slot = static_cast<std::uint32_t>(chunk * VisibleSlots::kChunk);
      for (std::uint32_t k = 0; k < visible.chunk_counts[chunk]; ++k, ++slot, ++to) {
        const auto key = std::bit_cast<std::uint32_t>(visible.depths[slot]);
        low = std::min(low, key);
        high = std::max(high, key);
        order.keys[to] = key;
        order.slots[to] = slot;
      }
    }
    ranges[static_cast<std::size_t>(worker)] = {low, high};
  });
  std::pair<std::uint32_t, std::uint32_t> all{~0u, 0u};
  for (const auto& [low, high] : ranges)
    all = {std::min(all.first, low), std::max(all.second, high)};
  return all;
}

}  // namespace

// A stable least-significant-digit radix sort. Depths are positive floats, whose bits order like
// unsigned integers, and so do their differences from the smallest: few bits, few passes. Slots go
// in by ascending index, so ties stay so. Every thread counts and then moves one segment of the
// items; where it moves them to does not depend on how many segments there are.
void sort(const FrameContext& frame, const VisibleSlots& visible, DepthOrder& order) {
  constexpr int kMaxDigitBits = 11;
  for (auto* array : {&order.keys, &order.slots, &order.other_keys, &order.other_slots})
    array->resize(visible.count);
  if (visible.count == 0) return;
  const auto [low, high] = gather(frame, visible, order);
  const int bits = std::bit_width(high - low);
  const int passes = (bits + kMaxDigitBits - 1) / kMaxDigitBits;
  const int digit_bits = passes == 0 ? 0 : (bits + passes - 1) / passes;
  const std::size_t buckets = std::size_t{1} << digit_bits;
  const auto segments = static_cast<std::size_t>(frame.pool.size());

  for (int pass = 0; pass < passes; ++pass) {
    const auto digit = [&, smallest = low](std::uint32_t key) {
      return ((key - smallest) >> (pass * digit_bits)) & (buckets - 1);
    };
    order.offsets.assign(segments * buckets, 0);
    frame.for_chunks(segments, 1, [&](std::size_t s, std::size_t, int) {
      std::uint32_t* counts = &order.offsets[s * buckets];
      const auto [begin, end] = segment(s, segments, order.keys.size());
      for (std::size_t i = begin; i < end; ++i) ++counts[digit(order.keys[i])];
    });
    std::uint32_t sum = 0;
    for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
      for (std::size_t s = 0; s < segments; ++s)
        sum += std::exchange(order.offsets[s * buckets + bucket], sum);
    }
    frame.for_chunks(segments, 1, [&](std::size_t s, std::size_t, int) {
      std::uint32_t* offsets = &order.offsets[s * buckets];
      const auto [begin, end] = segment(s, segments, order.keys.size());
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t to = offsets[digit(order.keys[i])]++;
        order.other_keys[to] = order.keys[i];
        order.other_slots[to] = order.slots[i];
      }
    });
    order.keys.swap(order.other_keys);
    order.slots.swap(order.other_slots);
  }
}

}  // namespace qs::cpu::fast
