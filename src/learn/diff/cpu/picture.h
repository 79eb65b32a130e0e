// SPDX-License-Identifier: MIT
//
// The pixels of a picture by tiles, and bounds of the pixels that a Gaussian reaches.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stop_token>

#include "base/error.h"
#include "base/parallel.h"
#include "learn/diff/blend_input.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cpu::diff {

using namespace qs::diff;

/// The threads of a pass, and the token that cancels it.
struct Workers {
  ThreadPool& pool;
  std::stop_token stop = {};

  /// Calls each(i) for i in [0, count), in parallel chunks of `grain`. Throws Cancelled.
  template <class Each>
  void for_each(std::size_t count, std::size_t grain, const Each& each) const {
    pool.for_chunks(count, grain, [&](std::size_t begin, std::size_t end, int) {
      if (stop.stop_requested()) throw Cancelled{};
      for (std::size_t i = begin; i < end; ++i) each(i);
    });
  }
};

/// Conservative bound of the pixels with alpha >= 1/255, row by row: it may include others.
struct PixelArea {
  glm::vec2 mean_px, half_px;  ///< a box around the mean
  float slope;                 ///< in row dy the middle is at dx = slope dy
  float gamma;                 ///< pixels count where a dx^2 + 2 b dx dy + c dy^2 <= gamma
  float by_row, by_column;     ///< 1 / variance of y, and 1 / a

  static PixelArea of(const Footprint& footprint);

  /// Columns of row y.
  float low(float y, float half) const { return mean_px.x + slope * (y - mean_px.y) - half; }
  float high(float y, float half) const { return mean_px.x + slope * (y - mean_px.y) + half; }
  /// Half the length of row y in pixels; < 0 if no pixel of the row counts.
  float half_length(float y) const {
    const float dy = y - mean_px.y;
    const float rest = gamma - dy * dy * by_row;
    return rest > 0 ? std::sqrt(rest * by_column) + 1 : -1;
  }
};

/// Pixels of a full tile.
inline constexpr auto kTilePixels = static_cast<std::size_t>(kTileSize * kTileSize);

/// The pixels of a tile that are inside the image.
struct TileBox {
  int x0, y0, width, height;

  static TileBox of(const PictureSize& size, std::size_t tile) {
    const int columns = size.grid().columns;
    const int x0 = static_cast<int>(tile) % columns * kTileSize;
    const int y0 = static_cast<int>(tile) / columns * kTileSize;
    return {x0, y0, std::min(kTileSize, size.width - x0), std::min(kTileSize, size.height - y0)};
  }

  /// Calls visit(x, y, i) for all pixels; i counts the pixels of a full tile row by row.
  template <class Visit>
  void for_each_pixel(const Visit& visit) const {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x)
        visit(x0 + x, y0 + y, static_cast<std::size_t>(y * kTileSize + x));
    }
  }

  /// Calls visit(x, y, pixel) for the pixels of the area.
  template <class Visit>
  void for_each_pixel(const PixelArea& area, const Visit& visit) const {
    const auto left = static_cast<float>(x0), top = static_cast<float>(y0);
    const float y = area.mean_px.y - top;
    const int end = clamp_to_int(y + area.half_px.y + 1, height);
    for (int row = clamp_to_int(y - area.half_px.y, height); row < end; ++row) {
      const float row_y = top + static_cast<float>(row);
      const float half = area.half_length(row_y);
      if (half < 0) continue;
      const int last = clamp_to_int(area.high(row_y, half) - left + 1, width);
      for (int x = clamp_to_int(area.low(row_y, half) - left, width); x < last; ++x)
        visit(x0 + x, y0 + row, static_cast<std::size_t>(row * kTileSize + x));
    }
  }
};

}  // namespace qs::cpu::diff
