// SPDX-License-Identifier: MIT
//
// The inputs of blend() and blend_backward() beside the frame.
#pragma once

#include <cstddef>

#include "learn/diff/strided_arrays.h"
#include "raster/kernel/blend.h"
#include "raster/kernel/tile_grid.h"

namespace qs::diff {

struct PictureSize {
  int width, height;

  TileGrid grid() const { return TileGrid::of_image(width, height); }
  std::size_t tiles() const { return static_cast<std::size_t>(grid().count()); }
  std::size_t pixels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  std::size_t pixel(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

template <class Real>
struct BlendInput {
  PictureSize size;
  PixelRules<Real> rules;
  int channel_count = 3;
  Rows<const Real> channels;  ///< channels of the Gaussians; not given: their colours in the frame
  const Real* background = nullptr;  ///< a number per channel; null: 0

  /// Throws Error(usage), in a sentence that starts with `who`. `has_depth`: the frame has depths;
  /// `wants_depth`: a picture needs them.
  void check(const char* who, bool has_depth, bool wants_depth) const;
  /// Throws such an Error if the frame has another size or number of channels.
  void check_frame(const char* who, const PictureSize& of_frame, int channels_of_frame) const;
};

}  // namespace qs::diff
