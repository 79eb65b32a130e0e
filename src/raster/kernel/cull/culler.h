// SPDX-License-Identifier: MIT
//
// The interface of a culling mode: a struct of static host+device functions, chosen once per frame.
//
//   struct MyMode {
//     static constexpr const char* kName = "my-mode";  // of its row in table.h
//     template <int kTilePx = kTileSize>
//     static QS_HD Walk walk(const Footprint&, TileGrid);
//   };
//
// A convex footprint meets every line of tiles in one contiguous run. So a mode is a Walk: an axis,
// a range of lines along it, the run of tiles in each line, and a run that contains all of them. A
// mode may instead define its own `bounds` and `for_each_tile_in`, as quadbox-naive does.
// To add a mode, write a header with such a struct, its row in table.h and its entry in modes.h;
// tests, command line and viewer find it there.
#pragma once

#include <type_traits>

#include "raster/kernel/footprint.h"
#include "raster/kernel/tile_grid.h"

namespace qs {

/// Half extents of the ellipse a x^2 + 2b x y + c y^2 <= gamma, in pixels, widened for fp32.
struct Extents {
  /// Half size of the axis-aligned bounding box: sqrt(gamma Sigma_xx), sqrt(gamma Sigma_yy).
  glm::vec2 max;
  float f;  ///< axis intercepts / max: sqrt(1 - rho^2), 0 < f <= about 1
  float k;  ///< the widening factor, already in `max` and `f`
};

/// f^2 = det / (Sxx Syy) stays precise on thin Gaussians, unlike 1 - b^2/(ac). The rounding of the
/// conic can enlarge its ellipse by about 2^-24 / f^2 of its size, which k covers.
QS_HD Extents extents(const Footprint& footprint) {
  const Covariance2<float>& s = footprint.covariance;
  const float f2 = footprint.determinant / (s.xx * s.yy);
  const float k = 1.0f + 4.0f * 5.9604644775390625e-8f / f2;
  return {{k * sqrtf(footprint.gamma * s.xx), k * sqrtf(footprint.gamma * s.yy)}, k * sqrtf(f2), k};
}

/// Tiles that the box mean +- half touches, clamped to the grid. Pixels; `half` >= 0.
template <int kTilePx = kTileSize>
QS_HD TileRect tiles_of_box(glm::vec2 mean, glm::vec2 half, TileGrid grid) {
  return {tiles_meeting<kTilePx>(mean.x - half.x, mean.x + half.x, grid.columns),
          tiles_meeting<kTilePx>(mean.y - half.y, mean.y + half.y, grid.rows)};
}

/// True if a walk's lines should be tile rows, false for columns: the direction with fewer lines.
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
  QS_HD Span widest() const { return tiles; }
};

/// Calls visit(line, span) for every line of the mode's walk, in ascending order.
template <class Walk, class Visit>
QS_HD void for_each_line(const Walk& walk, Visit&& visit) {
  for (int line = walk.lines.begin; line < walk.lines.end; ++line) visit(line, walk.span(line));
}

/// True if mode P is a Walk.
template <class P>
inline constexpr bool kWalks = requires {
  P::template walk<kTileSize>(Footprint{}, TileGrid{});
};

/// Calls visit(tile) with tile = row * columns + column once for every tile that mode P lists.
/// kTilePx is grid.tile_px. `footprint` is the result of project() or make_footprint(), with a
/// determinant > 0.
template <class P, int kTilePx = kTileSize, class Visit>
QS_HD void for_each_tile(const Footprint& footprint, TileGrid grid, Visit&& visit) {
  if constexpr (!kWalks<P>) {
    P::template for_each_tile_in<kTilePx>(
        footprint, grid, {{0, grid.columns}, {0, grid.rows}},
        [&](int column, int row) { visit(row * grid.columns + column); });
  } else {
    const auto walk = P::template walk<kTilePx>(footprint, grid);
    for_each_line(walk, [&](int line, Span span) {
      for (int tile = span.begin; tile < span.end; ++tile)
        visit(walk.by_rows ? line * grid.columns + tile : tile * grid.columns + line);
    });
  }
}

/// Number of tiles that for_each_tile visits, in constant time for a rectangle.
template <class P, int kTilePx = kTileSize>
QS_HD unsigned count_tiles(const Footprint& footprint, TileGrid grid) {
  unsigned count = 0;
  if constexpr (kWalks<P>) {
    const auto walk = P::template walk<kTilePx>(footprint, grid);
    if constexpr (std::is_same_v<decltype(walk), const RectWalk>)
      count = static_cast<unsigned>(walk.lines.size()) * static_cast<unsigned>(walk.tiles.size());
    else
      for_each_line(walk, [&](int, Span span) { count += static_cast<unsigned>(span.size()); });
  } else {
    for_each_tile<P, kTilePx>(footprint, grid, [&](int) { ++count; });
  }
  return count;
}

/// True if for_each_tile visits a tile. P is a Walk.
template <class P, int kTilePx = kTileSize>
QS_HD bool lists_a_tile(const Footprint& footprint, TileGrid grid) {
  const auto walk = P::template walk<kTilePx>(footprint, grid);
  for (int line = walk.lines.begin; line < walk.lines.end; ++line)
    if (walk.span(line).size() > 0) return true;
  return false;
}

/// A rectangle that contains all tiles that mode P lists; empty if it lists none.
template <class P, int kTilePx = kTileSize>
QS_HD TileRect bounds(const Footprint& footprint, TileGrid grid) {
  if constexpr (!kWalks<P>) {
    return P::template bounds<kTilePx>(footprint, grid);
  } else {
    const auto walk = P::template walk<kTilePx>(footprint, grid);
    Span lines = walk.lines;
    while (lines.size() > 0 && walk.span(lines.begin).size() == 0) ++lines.begin;
    const Span widest = lines.size() > 0 ? walk.widest() : Span{0, 0};
    return TileRect::of_lines(walk.by_rows, lines, widest);
  }
}

}  // namespace qs
