// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/sort.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace qs::cpu::fast {
namespace {

/// Copies depth bits and slots without unused slots. Returns the range of the bits.
KeyRange gather(const FrameContext& frame, const VisibleSlots& visible, FastDepthOrder& order) {
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

/// Sorts runs of equal depth by index in the cloud, because the radix sort left them in order of
/// slots, which is spatial. Ties are found without branches and their indices prefetched. The chunk
/// that contains the begin of a run sorts the whole run.
void order_ties(const FrameContext& frame, const VisibleSlots& visible, SortItems& items) {
  constexpr std::size_t kBatch = 512;
  const std::uint32_t* keys = items.keys.data();
  const std::uint32_t* gaussians = visible.gaussians.data();
  const std::size_t size = items.keys.size();
  const auto earlier = [&](std::uint32_t a, std::uint32_t b) {
    return gaussians[a] < gaussians[b];
  };
  frame.for_chunks(size, kBatch, [&](std::size_t begin, std::size_t end, int) {
    // Find the items that have the depth of the next item.
    std::size_t ties[kBatch], count = 0;
    end = std::min(end, size - 1);
    for (std::size_t i = begin; i < end; ++i) {
      ties[count] = i;
      count += static_cast<std::size_t>(keys[i] == keys[i + 1]);
    }
    // Keep the first item of each run.
    std::size_t runs = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = ties[k];
      if (i > 0 && keys[i - 1] == keys[i]) continue;
      __builtin_prefetch(gaussians + items.values[i]);
      __builtin_prefetch(gaussians + items.values[i + 1]);
      ties[runs++] = i;
    }
    // Sort the runs.
    for (std::size_t k = 0; k < runs; ++k) {
      const std::size_t i = ties[k];
      std::size_t length = 2;
      while (i + length < size && keys[i + length] == keys[i]) ++length;
      std::uint32_t* slots = &items.values[i];
      if (length > 2) {
        std::sort(slots, slots + length, earlier);
      } else if (earlier(slots[1], slots[0])) {
        std::swap(slots[0], slots[1]);
      }
    }
  });
}

}  // namespace

// Depths are positive floats; their bits order like unsigned integers.
void sort(const FrameContext& frame, const VisibleSlots& visible, FastDepthOrder& order) {
  order.items.resize(visible.count);
  const KeyRange range = gather(frame, visible, order);
  radix_sort(order.items, range, frame.pool, frame.stop);
  order_ties(frame, visible, order.items);
}

}  // namespace qs::cpu::fast
