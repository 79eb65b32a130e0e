// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cpu/fast/pipeline.h"

namespace qs::cpu::fast {
namespace {

/// Prefetch distance in Gaussians. They are read front to back but stored in spatial order.
constexpr std::size_t kPrefetch = 16;

/// Computes lists.begin from the corner differences that preprocess counted.
void find_begins(const FrameContext& frame, const FastVisible& visible, TileLists& lists) {
  const auto columns = static_cast<std::size_t>(frame.grid.columns);
  const auto rows = static_cast<std::size_t>(frame.grid.rows);
  lists.begin.resize(rows * columns + 1);
  lists.column_counts.assign(columns + 1, 0);  // sums over the rows so far
  std::uint64_t sum = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    for (const Array<std::int32_t>& corners : visible.corners)
      for (std::size_t column = 0; column <= columns; ++column)
        lists.column_counts[column] += corners[row * (columns + 1) + column];
    std::int64_t count = 0;
    for (std::size_t column = 0; column < columns; ++column) {
      count += lists.column_counts[column];
      lists.begin[row * columns + column] = sum;
      sum += static_cast<std::uint64_t>(count);
    }
  }
  lists.begin[rows * columns] = sum;
}

}  // namespace

// Every thread lists the Gaussians of its band front to back. So one thread writes each list in
// order, and the result does not depend on the number of bands.
void bin(const FrameContext& frame, const FastVisible& visible, const Bands& bands,
         TileLists& lists) {
  find_begins(frame, visible, lists);
  refuse_if_too_many(lists.pairs());
  lists.slots.resize(lists.pairs());
  lists.cursors.assign(lists.begin.begin(), lists.begin.end());

  frame.for_chunks(bands.size(), 1, [&](std::size_t b, std::size_t, int) {
    const Band& band = *bands[b];
    const Array<std::uint32_t>& slots = band.slots();
    const std::size_t count = slots.size();
    const auto add = [&](const PackedTileRect& rect, std::uint32_t slot) {
      const int row_end = std::min<int>(rect.row_end, band.bottom);
      for (int row = std::max<int>(rect.row_begin, band.top); row < row_end; ++row) {
        std::uint64_t* cursors = &lists.cursors[static_cast<std::size_t>(row * frame.grid.columns)];
        for (int column = rect.column_begin; column < rect.column_end; ++column)
          lists.slots[cursors[column]++] = slot;
      }
    };
    for (std::size_t i = 0; i < count; ++i) {
      // Prefetch the listings of the next Gaussians, then their rectangles.
      if (i + kPrefetch < count) __builtin_prefetch(&visible.listings[slots[i + kPrefetch]]);
      if (i + kPrefetch / 2 < count) {
        const std::uint32_t soon = slots[i + kPrefetch / 2];
        if (!visible.listings[soon].single()) __builtin_prefetch(visible.rects_of(soon));
      }
      if (i % 65536 == 0 && frame.stop.stop_requested()) throw Cancelled{};
      const std::uint32_t slot = slots[i];
      const Listing& listing = visible.listings[slot];
      if (listing.single()) {
        add(listing.rect, slot);
      } else {
        const PackedTileRect* rects = visible.rects_of(slot);
        for (std::uint32_t k = 0; k < listing.several.count; ++k) add(rects[k], slot);
      }
    }
  });
}

}  // namespace qs::cpu::fast
