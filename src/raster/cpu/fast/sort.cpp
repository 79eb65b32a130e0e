// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/sort.h"

#include <algorithm>
#include <bit>

namespace qs::cpu::fast {
namespace {

/// Copies depth bits and slots without the gaps of Visible. Returns the range of the bits.
KeyRange gather(const FrameContext& frame, const VisibleSlots& visible, DepthOrder& order) {
  const std::size_t chunks = visible.chunk_counts.size();
  order.begins.resize(chunks);
  std::exclusive_scan(visible.chunk_counts.begin(), visible.chunk_counts.end(),
                      order.begins.begin(), 0u);
  order.ranges.assign(static_cast<std::size_t>(frame.pool.size()), {});
  frame.for_chunks(chunks, 8, [&](std::size_t begin, std::size_t end, int worker) {
    KeyRange range;
    for (std::size_t chunk = begin; chunk < end; ++chunk) {
      std::size_t to = order.begins[chunk];
      auto slot = static_cast<std::uint32_t>(chunk * VisibleSlots::kChunk);
      for (std::uint32_t k = 0; k < visible.chunk_counts[chunk]; ++k, ++slot, ++to) {
        const auto key = std::bit_cast<std::uint32_t>(visible.depths[slot]);
        range.include(key);
        order.items.keys[to] = key;
        order.items.values[to] = slot;
      }
    }
    order.ranges[static_cast<std::size_t>(worker)].include(range);
  });
  KeyRange all;
  for (const KeyRange& range : order.ranges) all.include(range);
  return all;
}

/// Slots ascend in space; of equal depths the cloud's order counts. Whoever has the begin of a run
/// of equal depths orders all of it.
void order_ties(const FrameContext& frame, const VisibleSlots& visible, SortItems& items) {
  const Array<std::uint32_t>& keys = items.keys;
  const auto earlier = [&](std::uint32_t a, std::uint32_t b) {
    return visible.gaussians[a] < visible.gaussians[b];
  };
  frame.for_chunks(keys.size(), 16384, [&](std::size_t begin, std::size_t end, int) {
    std::size_t i = begin;
    while (i > 0 && i < end && keys[i] == keys[begin - 1]) ++i;
    for (; i < end; ++i) {
      if (i + 1 == keys.size() || keys[i] != keys[i + 1]) continue;
      const std::size_t first = i;
      while (i + 1 < keys.size() && keys[i + 1] == keys[first]) ++i;
      const auto slots = items.values.begin();
      std::sort(slots + static_cast<std::ptrdiff_t>(first),
                slots + static_cast<std::ptrdiff_t>(i + 1), earlier);
    }
  });
}

}  // namespace

// Depths are positive floats, whose bits order like unsigned integers.
void sort(const FrameContext& frame, const VisibleSlots& visible, DepthOrder& order) {
  order.items.resize(visible.count);
  const KeyRange range = gather(frame, visible, order);
  radix_sort(order.items, range, frame.pool, frame.stop);
  order_ties(frame, visible, order.items);
}

}  // namespace qs::cpu::fast
