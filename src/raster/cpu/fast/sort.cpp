// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/sort.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace qs::cpu::fast {
namespace {

/// Sets the tile rows of the bands, so that all bands have about the same number of pairs.
void find_bands(TileGrid grid, const FastVisible& visible, FastDepthOrder& order) {
  // Pairs per row, from corner differences: a rectangle of c columns adds c to its first row.
  const auto stride = static_cast<std::size_t>(grid.columns) + 1;
  const auto pairs_more = [&](int row) {
    std::int64_t more = 0;
    for (const Array<std::int32_t>& corners : visible.corners) {
      for (std::size_t column = 0; column < stride - 1; ++column)
        more += corners[static_cast<std::size_t>(row) * stride + column] *
                static_cast<std::int64_t>(stride - 1 - column);
    }
    return more;
  };
  std::int64_t all = 0, in_row = 0;
  for (int row = 0; row < grid.rows; ++row) all += in_row += pairs_more(row);
  std::int64_t above = 0;
  int row = 0;
  in_row = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    Band& band = *order[i];
    band.top = row;
    const auto target =
        all * static_cast<std::int64_t>(i + 1) / static_cast<std::int64_t>(order.size());
    for (; row < grid.rows && (above < target || i + 1 == order.size()); ++row)
      above += in_row += pairs_more(row);
    band.bottom = row;
  }
}

/// Copies depth bits and slots of the Gaussians that reach a band. Returns the range of the bits.
KeyRange gather(const FastVisible& visible, Band& band) {
  const auto reaches = [&](std::uint32_t slot) {
    return visible.rows[slot].begin < band.bottom && visible.rows[slot].end > band.top;
  };
  std::size_t count = 0;
  visible.for_each([&](std::uint32_t slot) { count += reaches(slot) ? 1 : 0; });
  band.items.resize(count + 1);  // one more, because every slot is stored first
  KeyRange range;
  std::size_t to = 0;
  visible.for_each([&](std::uint32_t slot) {
    const auto key = std::bit_cast<std::uint32_t>(visible.depths[slot]);
    const bool kept = reaches(slot);
    band.items.keys[to] = key;
    band.items.values[to] = slot;
    to += kept ? 1 : 0;
    range.low = kept ? std::min(range.low, key) : range.low;
    range.high = kept ? std::max(range.high, key) : range.high;
  });
  band.items.resize(count);
  return range;
}

/// Sorts runs of equal depth by index in the cloud, because the radix sort left them in order of
/// slots, which is spatial. Ties are found without branches and their indices prefetched.
void order_ties(const VisibleSlots& visible, SortItems& items) {
  constexpr std::size_t kBatch = 512;
  const std::uint32_t* keys = items.keys.data();
  const std::uint32_t* gaussians = visible.gaussians.data();
  const std::size_t size = items.keys.size();
  const auto earlier = [&](std::uint32_t a, std::uint32_t b) {
    return gaussians[a] < gaussians[b];
  };
  for (std::size_t begin = 0; begin + 1 < size; begin += kBatch) {
    // Find the items that have the depth of the next item.
    std::size_t ties[kBatch], count = 0;
    const std::size_t end = std::min(begin + kBatch, size - 1);
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
  }
}

}  // namespace

// Depths are positive floats; their bits order like unsigned integers.
void sort(const FrameContext& frame, const FastVisible& visible, FastDepthOrder& order) {
  while (order.size() < static_cast<std::size_t>(frame.pool.size()))
    order.push_back(std::make_unique<Band>());
  order.resize(static_cast<std::size_t>(frame.pool.size()));
  find_bands(frame.grid, visible, order);
  frame.for_chunks(order.size(), 1, [&](std::size_t i, std::size_t, int) {
    Band& band = *order[i];
    const KeyRange range = gather(visible, band);
    radix_sort(band.items, range, band.alone, frame.stop);
    order_ties(visible, band.items);
  });
}

}  // namespace qs::cpu::fast
