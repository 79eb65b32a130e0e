// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/bin.h"

#include <algorithm>

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
    for (const Array<std::int32_t>& corners : visible.corners) {
      for (std::size_t column = 0; column <= columns; ++column)
        lists.column_counts[column] += corners[row * (columns + 1) + column];
    }
    std::int64_t count = 0;
    for (std::size_t column = 0; column < columns; ++column) {
      count += lists.column_counts[column];
      lists.begin[row * columns + column] = sum;
      sum += static_cast<std::uint64_t>(count);
    }
  }
  lists.begin[rows * columns] = sum;
}

/// The lists of a band, while they are filled.
struct Lists {
  std::uint64_t* cursors;  ///< per tile: where its next slot is stored in `slots`
  std::uint32_t* slots;
  std::size_t columns;  ///< of tiles
};

/// Lists a slot in kRows x kColumns tiles, from tile `first` on.
template <std::size_t kRows, std::size_t kColumns>
void add_fixed(const Lists& lists, std::size_t first, std::uint32_t slot) {
  for (std::size_t row = 0; row < kRows; ++row) {
    std::uint64_t* cursors = lists.cursors + first + row * lists.columns;
    for (std::size_t column = 0; column < kColumns; ++column) lists.slots[cursors[column]++] = slot;
  }
}

/// add_fixed() for small rectangles, [rows - 1][columns - 1]. A CPU cannot predict the lengths of
/// loops over them, so a jump replaces the loops.
using Add = void (*)(const Lists&, std::size_t, std::uint32_t);
constexpr int kFixed = 4;
constexpr Add kAdds[kFixed][kFixed] = {
    {add_fixed<1, 1>, add_fixed<1, 2>, add_fixed<1, 3>, add_fixed<1, 4>},
    {add_fixed<2, 1>, add_fixed<2, 2>, add_fixed<2, 3>, add_fixed<2, 4>},
    {add_fixed<3, 1>, add_fixed<3, 2>, add_fixed<3, 3>, add_fixed<3, 4>},
    {add_fixed<4, 1>, add_fixed<4, 2>, add_fixed<4, 3>, add_fixed<4, 4>}};

/// Lists a slot in the rows of a rectangle that belong to the band.
void add_rect(const Lists& lists, const Band& band, PackedTileRect rect, std::uint32_t slot) {
  const int top = std::max<int>(rect.row_begin, band.top);
  const int rows = std::min<int>(rect.row_end, band.bottom) - top;
  const int columns = rect.column_end - rect.column_begin;
  if (rows <= 0) return;
  const std::size_t first = static_cast<std::size_t>(top) * lists.columns + rect.column_begin;
  if (rows <= kFixed && columns <= kFixed) [[likely]]
    return kAdds[rows - 1][columns - 1](lists, first, slot);
  for (int row = 0; row < rows; ++row) {
    std::uint64_t* cursors = lists.cursors + first + static_cast<std::size_t>(row) * lists.columns;
    for (int column = 0; column < columns; ++column) lists.slots[cursors[column]++] = slot;
  }
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
    const Lists filled{lists.cursors.data(), lists.slots.data(),
                       static_cast<std::size_t>(frame.grid.columns)};
    for (std::size_t i = 0; i < count; ++i) {
      // Prefetch the listings of the next Gaussians, then their rectangles.
      if (i + kPrefetch < count) __builtin_prefetch(&visible.listings[slots[i + kPrefetch]]);
      if (i + kPrefetch / 2 < count) {
        __builtin_prefetch(visible.rects_of(slots[i + kPrefetch / 2]));
      }
      if (i % 65536 == 0 && frame.stop.stop_requested()) throw Cancelled{};
      const std::uint32_t slot = slots[i];
      const Listing& listing = visible.listings[slot];
      const PackedTileRect* rects = listing.count == 1 ? &listing.bounds : visible.rects_of(slot);
      for (std::uint32_t k = 0; k < listing.count; ++k) add_rect(filled, band, rects[k], slot);
    }
  });
}

}  // namespace qs::cpu::fast
