// SPDX-License-Identifier: MIT
//
// Which tiles the frame's mode gives to Gaussians, as rectangles of tiles that do not overlap: few
// numbers where a Gaussian has many tiles, and the same for walks along rows and along columns.
// They are found once per frame; counting and binning read them.
#pragma once

#include "raster/cpu/fast/survivors.h"
#include "raster/kernel/cull/modes.h"

namespace qs::cpu::fast {

/// Rows and columns [begin, end) of tiles; sides of pictures are below 2^20 pixels.
struct Rect {
  std::uint16_t row_begin, row_end, column_begin, column_end;
};

/// The rectangles of the visible Gaussians of a chunk, one Gaussian after the other. Not a vector's
/// push_back(), whose call costs more than all that it does here.
class RectList {
 public:
  std::size_t size() const { return size_; }
  const Rect& operator[](std::size_t i) const { return rects_[i]; }

  void clear() { size_ = 0; }
  void add(Rect rect) {
    if (size_ == rects_.size()) [[unlikely]]
      grow();
    rects_[size_++] = rect;
  }

 private:
  void grow() { rects_.resize(2 * size_ + 2048); }

  Array<Rect> rects_;  ///< as many as there is room for
  std::size_t size_ = 0;
};

/// What one Gaussian has of them.
struct Listing {
  Rect bounds;          ///< of all of them: of a single one, itself
  std::uint32_t first;  ///< in its chunk's RectList
  std::uint32_t count;  ///< > 0
};

/// Appends the rectangles of `survivors` to `rects`, writes listings[k] for those that have any,
/// and packs `survivors` to these.
void list_tiles(CullMode mode, TileGrid grid, Survivors& survivors, RectList& rects,
                Listing* listings);

}  // namespace qs::cpu::fast
