// SPDX-License-Identifier: MIT
//
// The tiles that the culling mode assigns to each Gaussian, as rectangles that do not overlap.
// Rectangles are short lists even for Gaussians with many tiles, and have the same form for walks
// along rows and along columns. They are computed once per frame; counting and binning read them.
#pragma once

#include "raster/cpu/fast/survivors.h"
#include "raster/kernel/cull/mode.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cpu::fast {

/// Rows and columns [begin, end) of tiles. Sides of images are below 2^20 pixels.
struct PackedTileRect {
  std::uint16_t row_begin, row_end, column_begin, column_end;
};

/// The rectangles of a chunk's visible Gaussians, one Gaussian after the other. add() is inlined,
/// because calls of std::vector::push_back() were slow here.
class RectList {
 public:
  std::size_t size() const { return size_; }
  const PackedTileRect& operator[](std::size_t i) const { return rects_[i]; }

  void clear() { size_ = 0; }
  void add(PackedTileRect rect) {
    if (size_ == rects_.size()) [[unlikely]]
      grow();
    rects_[size_++] = rect;
  }

 private:
  void grow() { rects_.resize(2 * size_ + 2048); }

  Array<PackedTileRect> rects_;  ///< its size is the capacity
  std::size_t size_ = 0;
};

/// The rectangles of one Gaussian: one, or several in its chunk's RectList. Bin reads listings in
/// random order, so they are small.
union Listing {
  struct Several {
    std::uint16_t mark;   ///< kSeveral, which is no first row
    std::uint16_t count;  ///< > 1
    std::uint32_t first;
  };
  static constexpr std::uint16_t kSeveral = 65535;

  PackedTileRect rect;
  Several several;

  bool single() const { return rect.row_begin != kSeveral; }
};

/// Appends the rectangles of `survivors` to `rects`, removes survivors without any, and writes
/// listings[k] and rows[k] for the k-th survivor that remains. `rows`: see FastVisible.
void list_tiles(CullMode mode, TileGrid grid, Survivors& survivors, RectList& rects,
                Listing* listings, std::uint32_t* rows);

}  // namespace qs::cpu::fast
