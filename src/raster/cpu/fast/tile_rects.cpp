// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cpu/fast/pipeline.h"
#include "raster/kernel/cull/modes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/tile_rects.cpp"
// clang-format off
#include "base/simd.h"
#include "raster/cpu/fast/walk_vectors.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {

/// The walks of a block's survivors and the spans of their first lines, one array per value. They
/// are computed by vectors, because their conditions are unpredictable as branches. All modes have
/// vector code, except quadbox-naive, whose loops are not a walk. So no mode is faster only because
/// of its implementation. A new mode works without vector code, more slowly.
struct alignas(64) Walks {
  static constexpr int kLines = 4;
  std::int32_t by_rows[kBlock];  ///< 0 or not
  std::int32_t lines_begin[kBlock], lines_end[kBlock];
  std::int32_t begin[kLines][kBlock], end[kLines][kBlock];

  /// Equals the mode's walk() in kernel/cull/ bit for bit.
  template <class P>
  HWY_INLINE void compute(TileGrid grid, const Survivors& s) {
    const DI di;
    for (std::size_t k = 0; k < s.count; k += hn::Lanes(di)) {
      const Walk<P> walk(Footprints(s, k), grid);
      hn::Store(hn::VecFromMask(di, hn::RebindMask(di, walk.by_rows)), di, by_rows + k);
      hn::Store(walk.lines.begin, di, lines_begin + k);
      hn::Store(walk.lines.end, di, lines_end + k);
      for (int line = 0; line < kLines; ++line) {
        const Spans span = walk.span(hn::Add(walk.lines.begin, hn::Set(di, line)));
        hn::Store(span.begin, di, begin[line] + k);
        hn::Store(span.end, di, end[line] + k);
      }
    }
  }
  bool has_all_spans(std::size_t k) const { return lines_end[k] - lines_begin[k] <= kLines; }
};

/// Appends rectangles one at a time and merges each with the last rectangle if the union is a
/// rectangle.
class Joiner {
 public:
  explicit Joiner(RectList& rects) : rects_(rects), first_(rects.size()) {}

  HWY_INLINE void add(int row_begin, int row_end, int column_begin, int column_end) {
    if (!open_.any()) {
      open_ = {row_begin, row_end, column_begin, column_end};
    } else if (open_.column_begin == column_begin && open_.column_end == column_end &&
               open_.row_end == row_begin) {
      open_.row_end = row_end;
    } else if (open_.row_begin == row_begin && open_.row_end == row_end &&
               open_.column_end == column_begin) {
      open_.column_end = column_end;
    } else {
      close();
      open_ = {row_begin, row_end, column_begin, column_end};
    }
  }

  /// Writes the Gaussian's listing and tile rows. False if no rectangle was added.
  HWY_INLINE bool finish(Listing& listing, std::uint32_t& rows) {
    if (!open_.any()) return false;
    close();
    rows = top_ + (std::uint32_t{bottom_} << 16);
    const std::size_t count = rects_.size() - first_;
    if (count == 1) {
      listing.rect = rects_[first_];
    } else {
      listing.several = {Listing::kSeveral, static_cast<std::uint16_t>(count),
                         static_cast<std::uint32_t>(first_)};
    }
    return true;
  }

 private:
  struct Open {
    int row_begin = 0, row_end = 0, column_begin = 0, column_end = 0;
    bool any() const { return row_end != 0; }
  };

  HWY_INLINE void close() {
    const auto narrow = [](int tile) HWY_ATTR { return static_cast<std::uint16_t>(tile); };
    const PackedTileRect rect{narrow(open_.row_begin), narrow(open_.row_end),
                              narrow(open_.column_begin), narrow(open_.column_end)};
    rects_.add(rect);
    top_ = std::min(top_, rect.row_begin);
    bottom_ = std::max(bottom_, rect.row_end);
  }

  RectList& rects_;
  std::size_t first_;
  Open open_;
  std::uint16_t top_ = 65535, bottom_ = 0;
};

HWY_INLINE void add_line(bool by_rows, int line, int begin, int end, Joiner& joiner) {
  if (begin >= end) return;
  if (by_rows) {
    joiner.add(line, line + 1, begin, end);
  } else {
    joiner.add(begin, end, line, line + 1);
  }
}

template <class P>
HWY_INLINE void add_rects(const Footprint& footprint, TileGrid grid, Joiner& joiner) {
  if constexpr (kWalks<P>) {
    const auto walk = P::walk(footprint, grid);
    for (int line = walk.lines.begin; line < walk.lines.end; ++line) {
      const Span span = walk.span(line);
      add_line(walk.by_rows, line, span.begin, span.end, joiner);
    }
  } else {
    const TileRect all{{0, grid.columns}, {0, grid.rows}};
    P::for_each_tile_in(footprint, grid, all, [&](int column, int row) HWY_ATTR {
      joiner.add(row, row + 1, column, column + 1);
    });
  }
}

HWY_INLINE void add_walked(const Walks& walks, std::size_t k, Joiner& joiner) {
  const int lines = walks.lines_end[k] - walks.lines_begin[k];
  for (int i = 0; i < lines; ++i)
    add_line(walks.by_rows[k] != 0, walks.lines_begin[k] + i, walks.begin[i][k], walks.end[i][k],
             joiner);
}

template <class P>
HWY_INLINE void list_with(TileGrid grid, Survivors& s, RectList& rects, Listing* listings,
                          std::uint32_t* rows) {
  Walks walks;
  if constexpr (HasVectors<P>) walks.compute<P>(grid, s);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < s.count; ++k) {
    Joiner joiner(rects);
    if (HasVectors<P> && walks.has_all_spans(k)) {
      add_walked(walks, k, joiner);
    } else {
      add_rects<P>(s.footprint(k), grid, joiner);
    }
    if (!joiner.finish(listings[kept], rows[kept])) continue;
    if (kept != k) {
      s.lane[kept] = s.lane[k];
      for (float* plane : {s.mean_x, s.mean_y, s.xx, s.xy, s.yy, s.conic_a, s.conic_b, s.conic_c,
                           s.determinant, s.gamma, s.depth, s.log2_opacity})
        plane[kept] = plane[k];
    }
    ++kept;
  }
  s.count = kept;
}

void list_block(CullMode mode, TileGrid grid, Survivors& survivors, RectList& rects,
                Listing* listings, std::uint32_t* rows) {
  with_culler(mode,
              [&]<class P>(P) HWY_ATTR { list_with<P>(grid, survivors, rects, listings, rows); });
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(list_block);

void list_tiles(CullMode mode, TileGrid grid, Survivors& survivors, RectList& rects,
                Listing* listings, std::uint32_t* rows) {
  HWY_DYNAMIC_DISPATCH(list_block)(mode, grid, survivors, rects, listings, rows);
}

}  // namespace qs::cpu::fast
#endif
