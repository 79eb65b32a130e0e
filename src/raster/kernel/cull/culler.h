// SPDX-License-Identifier: MIT
//
// What a culling mode is: a struct of static host+device functions, chosen once per frame.
//
//   struct MyMode {
//     static constexpr const char* kName = "my-mode";      // CLI, GUI, CSV
//     static constexpr const char* kSummary = "...";       // one clause for tables and help
//     static constexpr bool kLossless = true;              // no pixel with alpha >= 1/255 is lost
//     static constexpr bool kKeepsFaint = false;           // opacity <= 1/255 still counts as
//                                                          // visible
//     template <int kTilePx = kTileSize>                   // lines to visit, and what span() needs
//     static QS_HD Walk walk(const Footprint&, TileGrid);
//   };
//
// A convex footprint meets every line of tiles in one contiguous run, so a mode is a Walk: an axis,
// a range of lines along it, and the run of tiles in each. The walk goes along the shorter axis.
// To add a mode: a new header with such a struct, one entry in list.h, and the tests find it there.
// A mode may instead bring its own `for_each_tile` (quadbox-naive does).
//
// The counting function and the emitting function are the same code: for_each_tile.
#pragma once

#include "raster/kernel/footprint.h"
#include "raster/kernel/tile_grid.h"

namespace qs {

/// Half extents of the ellipse a x^2 + 2b x y + c y^2 <= gamma, in pixels, widened for fp32.
struct Extents {
  glm::vec2 max;  ///< of the axis-aligned bounding box: sqrt(gamma Sigma_xx), sqrt(gamma Sigma_yy)
  float f;  ///< intercepts over max: x_inter/x_max = y_inter/y_max = sqrt(1 - rho^2), 0 < f <=
            ///< about 1
  float k;  ///< the widening already in `max` and `f`
};

/// f^2 = det / (Sxx Syy), which keeps its precision on needles where 1 - b^2/(ac) does not.
/// The conic's own rounding can move its ellipse outwards by about 2^-24 / f^2; k makes room for
/// that.
QS_HD Extents extents(const Footprint& footprint) {
  const Covariance2<float>& s = footprint.covariance;
  const float f2 = footprint.determinant / (s.xx * s.yy);
  const float k = 1.0f + 4.0f * 5.9604644775390625e-8f / f2;
  return {{k * sqrtf(footprint.gamma * s.xx), k * sqrtf(footprint.gamma * s.yy)}, k * sqrtf(f2), k};
}

/// Tiles that the box mean +- half meets.
template <int kTilePx = kTileSize>
QS_HD TileRect tiles_of_box(glm::vec2 mean, glm::vec2 half, TileGrid grid) {
  return {tiles_meeting<kTilePx>(mean.x - half.x, mean.x + half.x, grid.columns),
          tiles_meeting<kTilePx>(mean.y - half.y, mean.y + half.y, grid.rows)};
}

/// Which axis a walk follows: its lines are tile rows when `by_rows`, tile columns otherwise.
/// The shorter side of the rectangle gives fewer lines.
QS_HD bool walks_rows(const TileRect& rect) { return rect.rows.size() <= rect.columns.size(); }

/// A walk over a full rectangle of tiles.
struct RectWalk {
  bool by_rows;
  Span lines;
  Span tiles;

  static QS_HD RectWalk over(const TileRect& rect) {
    const bool by_rows = walks_rows(rect);
    return {by_rows, by_rows ? rect.rows : rect.columns, by_rows ? rect.columns : rect.rows};
  }
  QS_HD Span span(int) const { return tiles; }
};

/// Calls visit(line, span) for every line of the mode's walk, in ascending order.
template <class Walk, class Visit>
QS_HD void for_each_line(const Walk& walk, Visit&& visit) {
  for (int line = walk.lines.begin; line < walk.lines.end; ++line) visit(line, walk.span(line));
}

/// Calls visit(tile) with tile = row * columns + column once for every tile that mode P lists.
/// kTilePx is grid.tile_px.
template <class P, int kTilePx = kTileSize, class Visit>
QS_HD void for_each_tile(const Footprint& footprint, TileGrid grid, Visit&& visit) {
  if constexpr (requires { P::template for_each_tile<kTilePx>(footprint, grid, visit); }) {
    P::template for_each_tile<kTilePx>(footprint, grid, visit);
  } else {
    const auto walk = P::template walk<kTilePx>(footprint, grid);
    for_each_line(walk, [&](int line, Span span) {
      for (int tile = span.begin; tile < span.end; ++tile) {
        visit(walk.by_rows ? line * grid.columns + tile : tile * grid.columns + line);
      }
    });
  }
}

/// Number of tiles that for_each_tile visits.
template <class P, int kTilePx = kTileSize>
QS_HD unsigned count_tiles(const Footprint& footprint, TileGrid grid) {
  unsigned count = 0;
  if constexpr (requires { P::template walk<kTilePx>(footprint, grid); }) {
    for_each_line(P::template walk<kTilePx>(footprint, grid),
                  [&](int, Span span) { count += static_cast<unsigned>(span.size()); });
  } else {
    P::template for_each_tile<kTilePx>(footprint, grid, [&](int) { ++count; });
  }
  return count;
}

}  // namespace qs
