// SPDX-License-Identifier: MIT
//
// The tiles that a Gaussian lists, grouped by macro-tile. `project` appends Gaussians to
// macro-tiles with this code.
#pragma once

#include "raster/cuda/common/warp.cuh"
#include "raster/cuda/fast/stages.cuh"

namespace qs::cuda::fast {

/// A macro-tile's tiles, as a mask: bit kColumns * row + column.
struct MacroMask {
  static constexpr int kColumns = MacroTiles::kColumns, kRows = MacroTiles::kRows;

  TileRect window;  ///< the macro-tile's tiles, also those outside the grid
  unsigned mask = 0;

  __device__ MacroMask(int column, int row)
      : window{{column * kColumns, (column + 1) * kColumns}, {row * kRows, (row + 1) * kRows}} {}

  __device__ Span lines(bool by_rows) const { return by_rows ? window.rows : window.columns; }

  /// Adds the tiles of `span` in line `line` of a walk; `line` is in lines().
  __device__ void add(bool by_rows, int line, Span span) {
    const Span along = by_rows ? window.columns : window.rows;
    const Span run = intersection(span, along);
    if (run.size() == 0) return;
    const unsigned bits = ((1u << run.size()) - 1) << (run.begin - along.begin);
    if (by_rows) {
      mask |= bits << (line - window.rows.begin) * kColumns;
      return;
    }
#pragma unroll
    for (int row = 0; row < kRows; ++row)
      mask |= (bits >> row & 1) << (row * kColumns + line - window.columns.begin);
  }

  /// Adds the tiles of a walk, which lists span_at(line) in a line.
  template <class SpanAt>
  __device__ void add_walk(bool by_rows, Span lines_of_walk, const SpanAt& span_at) {
    const Span own = intersection(lines_of_walk, lines(by_rows));
    for (int line = own.begin; line < own.end; ++line) add(by_rows, line, span_at(line));
  }
};

/// The tiles of a macro-tile that mode P lists for a Gaussian.
template <class P>
__device__ unsigned tiles_in(const Footprint& footprint, TileGrid grid, int column, int row) {
  MacroMask listed(column, row);
  if constexpr (!kWalks<P>) {
    P::for_each_tile_in(footprint, grid, listed.window, [&](int tile_column, int tile_row) {
      listed.add(true, tile_row, {tile_column, tile_column + 1});
    });
  } else {
    const auto walk = P::walk(footprint, grid);
    listed.add_walk(walk.by_rows, walk.lines, [&](int line) { return walk.span(line); });
  }
  return listed.mask;
}

/// The macro-tiles that a rectangle of tiles meets.
__device__ inline TileRect macro_rect(const TileRect& tiles) {
  if (tiles.is_empty()) return {{0, 0}, {0, 0}};
  constexpr int kColumns = MacroTiles::kColumns, kRows = MacroTiles::kRows;
  return {{tiles.columns.begin / kColumns, (tiles.columns.end - 1) / kColumns + 1},
          {tiles.rows.begin / kRows, (tiles.rows.end - 1) / kRows + 1}};
}

/// A projected Gaussian in shared memory, with the walk of mode P unless that is large. Its size is
/// an odd number of words, so that lanes read different banks.
template <class P>
struct Appended {
  static constexpr int kLines = 12, kBits = 32;
  /// A block would take too long to append neighbours that meet more macro-tiles.
  static constexpr int kMacroTiles = 16;

  std::uint32_t depth_key;
  std::uint16_t line_begin, across_begin;  ///< the walk's first line and place;
                                           ///< across_begin: a macro-tile's border
  std::uint16_t macro_column, macro_row;   ///< the first macro-tile
  std::uint16_t inverse_width;             ///< 65,536 / macro_columns, rounded up
  std::uint8_t macro_columns, macro_rows;  ///< 0: not visible, or large
  std::uint8_t lines, by_rows, unused[2];
  std::uint32_t runs[kLines];  ///< per line: a bit per tile, from across_begin

  __device__ void clear() { macro_columns = macro_rows = 0; }
  __device__ bool has_walk() const { return macro_columns > 0; }

  /// Returns false if the Gaussian is visible, but too large for this record.
  __device__ bool set(const Footprint& footprint, TileGrid grid) {
    constexpr int kColumns = MacroTiles::kColumns, kRows = MacroTiles::kRows;
    if constexpr (!kWalks<P>) {
      const TileRect rect = bounds<P>(footprint, grid);
      if (rect.is_empty()) return true;
      if (rect.columns.size() > kBits || rect.rows.size() > kLines || meets_many(rect))
        return false;
      set_macro_tiles(rect);
    } else {
      const auto walk = P::walk(footprint, grid);
      const Span widest = walk.widest();
      const int border = walk.by_rows ? kColumns : kRows, first = widest.begin / border * border;
      if (walk.lines.size() > kLines || widest.end - first > kBits ||
          meets_many(TileRect::of_lines(walk.by_rows, walk.lines, widest))) {
        return bounds<P>(footprint, grid).is_empty();
      }
      std::uint32_t any = 0;
      for (int line = walk.lines.begin; line < walk.lines.end; ++line) {
        const Span run = walk.span(line);
        const std::uint32_t bits =
            run.size() > 0 ? (0xffffffffu >> (kBits - run.size())) << (run.begin - first) : 0;
        runs[line - walk.lines.begin] = bits;
        any |= bits;
      }
      if (any == 0) return true;
      line_begin = static_cast<std::uint16_t>(walk.lines.begin);
      across_begin = static_cast<std::uint16_t>(first);
      lines = static_cast<std::uint8_t>(walk.lines.size());
      by_rows = walk.by_rows;
      set_macro_tiles(TileRect::of_lines(walk.by_rows, walk.lines, widest));
    }
    return true;
  }

  __device__ unsigned tiles_in(int column, int row, std::uint32_t place, const FastVisible& visible,
                               TileGrid grid) const {
    constexpr int kColumns = MacroTiles::kColumns, kRows = MacroTiles::kRows;
    static_assert(kColumns == 4 && kRows == 2);
    if constexpr (!kWalks<P>) {
      return fast::tiles_in<P>(visible.footprints[place].footprint(), grid, column, row);
    } else {
      const int along = column * kColumns, down = row * kRows;
      const int first = (by_rows ? down : along) - line_begin;
      const int shift = (by_rows ? along : down) - across_begin;
      std::uint32_t own[kColumns];
#pragma unroll
      for (int i = 0; i < kColumns; ++i) {
        const bool is_in = first + i >= 0 && first + i < lines;
        own[i] = is_in ? runs[first + i] >> shift : 0;
      }
      if (by_rows) return (own[0] & 15) | (own[1] & 15) << kColumns;
      unsigned mask = 0;
#pragma unroll
      for (int i = 0; i < kColumns; ++i)
        mask |= (own[i] & 1) << i | (own[i] >> 1 & 1) << (kColumns + i);
      return mask;
    }
  }

 private:
  static __device__ bool meets_many(const TileRect& tiles) {
    const TileRect rect = macro_rect(tiles);
    return rect.columns.size() * rect.rows.size() > kMacroTiles;
  }

  __device__ void set_macro_tiles(const TileRect& tiles) {
    const TileRect rect = macro_rect(tiles);
    const auto width = static_cast<unsigned>(rect.columns.size());
    macro_column = static_cast<std::uint16_t>(rect.columns.begin);
    macro_row = static_cast<std::uint16_t>(rect.rows.begin);
    macro_columns = static_cast<std::uint8_t>(width);
    macro_rows = static_cast<std::uint8_t>(rect.rows.size());
    inverse_width = static_cast<std::uint16_t>(width > 1 ? (65536 + width - 1) / width : 0);
  }
};

/// An entry for a macro-tile, before its slot is known. It has the macro-tile's counter in
/// BlockCounts. The owner is a Gaussian of the block.
struct StagedEntry {
  std::uint32_t word;  // counter: 13 bits, owner: 11, mask: 8

  static constexpr unsigned kOwners = 1u << 11, kCounters = 1u << 13;
  static_assert(kThreads <= kOwners);

  __device__ explicit StagedEntry(std::uint32_t stored) : word(stored) {}
  __device__ StagedEntry(unsigned counter, unsigned owner, unsigned mask)
      : word(counter << 19 | owner << 8 | mask) {}
  static __device__ StagedEntry none() { return {kCounters - 1, 0, 0}; }
  __device__ unsigned counter() const { return word >> 19; }
  __device__ unsigned owner() const { return word >> 8 & (kOwners - 1); }
  __device__ unsigned mask() const { return word & 255; }
};

/// The entries of one block per macro-tile, in its dynamic shared memory. A picture with few
/// macro-tiles has a counter for each of them. In a larger picture a block reaches only a part of
/// them, and the counters are a hash table, so that the cost of a block does not grow with the
/// picture.
class BlockCounts {
 public:
  static constexpr unsigned kLog2Most = 11, kMost = 1u << kLog2Most;  ///< counters
  static_assert(kMost < StagedEntry::kCounters);

  static std::size_t bytes(std::size_t macro_tiles) {
    return (macro_tiles <= kMost ? macro_tiles : 2 * kMost) * sizeof(std::uint32_t);
  }

  __device__ BlockCounts(void* memory, unsigned macro_tiles)
      : counts_(static_cast<std::uint32_t*>(memory)),
        owners_(macro_tiles <= kMost ? nullptr : counts_ + kMost),
        size_(min(macro_tiles, kMost)) {}

  __device__ unsigned size() const { return size_; }
  __device__ std::uint32_t* counts() const { return counts_; }
  __device__ std::uint32_t& operator[](unsigned counter) const { return counts_[counter]; }

  /// The threads of the block call it together.
  __device__ void clear() const {
    for (unsigned i = threadIdx.x; i < size_; i += kThreads) counts_[i] = 0;
    for (unsigned i = threadIdx.x; i < size_ && owners_ != nullptr; i += kThreads)
      owners_[i] = kNone;
  }

  /// The counter of a macro-tile. A block may ask for less than kMost different ones.
  __device__ unsigned counter_of(unsigned macro_tile) const {
    if (owners_ == nullptr) return macro_tile;
    unsigned counter = hash_of(macro_tile, kLog2Most);
    for (;; counter = (counter + 1) % kMost) {
      const std::uint32_t owner = atomicCAS(&owners_[counter], kNone, macro_tile);
      if (owner == kNone || owner == macro_tile) return counter;
    }
  }

  /// The inverse, for counters that are not 0.
  __device__ unsigned macro_tile_of(unsigned counter) const {
    return owners_ == nullptr ? counter : owners_[counter];
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::uint32_t* counts_;
  std::uint32_t* owners_;  // per counter: its macro-tile; null: counter and macro-tile are equal
  unsigned size_;
};

/// Calls visit(exists, macro-tile, owner, mask of tiles) for each macro-tile that one of 32
/// Gaussians may meet. The Gaussians have the places from `first_place` on, and owners 0 to 31.
/// `exists` is true if the owner lists tiles there. All lanes of a warp call it together, share the
/// work and call visit() together.
template <class P, class Visit>
__device__ void for_each_macro_tile(const Appended<P>* gaussians, std::uint32_t first_place,
                                    const FastVisible& visible, const MacroTiles& macro_tiles,
                                    TileGrid grid, const Visit& visit) {
  static_assert(sizeof(Appended<P>) / sizeof(std::uint32_t) % 2 == 1);
  const Appended<P>& mine = gaussians[lane_index()];
  const unsigned own = unsigned{mine.macro_columns} * mine.macro_rows;
  const unsigned end = inclusive_sum_of_warp(own);
  const unsigned total = __shfl_sync(kAllLanes, end, kWarp - 1);
  for (unsigned first = 0; first < total; first += kWarp) {
    const unsigned item = first + lane_index();
    unsigned owner = 0;  // the first lane whose `end` exceeds the item
    for (unsigned step = kWarp / 2; step > 0; step /= 2)
      if (__shfl_sync(kAllLanes, end, owner + step - 1) <= item) owner += step;
    const unsigned place = item - __shfl_sync(kAllLanes, end - own, owner);
    unsigned tiles = 0, macro_tile = 0;
    if (item < total) {
      const Appended<P>& gaussian = gaussians[owner];
      const unsigned width = gaussian.macro_columns;
      const unsigned down = width > 1 ? place * gaussian.inverse_width >> 16 : place;
      const unsigned column = gaussian.macro_column + place - down * width;
      const unsigned row = gaussian.macro_row + down;
      tiles = gaussian.tiles_in(static_cast<int>(column), static_cast<int>(row),
                                first_place + owner, visible, grid);
      macro_tile = row * static_cast<unsigned>(macro_tiles.columns) + column;
    }
    visit(tiles != 0, macro_tile, owner, tiles);
  }
}

}  // namespace qs::cuda::fast
