// SPDX-License-Identifier: MIT
//
// Modes `quadbox-naive` and `quadbox` (QuadBox, ICIP 2026): one box in each quadrant around the
// mean. In the two quadrants along the major axis the box extends to x_max, y_max. In the two
// others 2 b x y >= 0, so the ellipse stays inside its axis intercepts f x_max, f y_max.
// `quadbox` is QPass: one walk over the shorter axis of the bounding tile range, which merges the
// intervals of the boxes in each line by min and max. All boxes contain the mean's row and column,
// so the union in a line is one run, and both modes list the same tiles.
#pragma once

#include "raster/kernel/cull/culler.h"

namespace qs {

/// The sizes of the quadrant boxes in pixels: the box of a quadrant spans |x| <= reach.x and
/// |y| <= reach.y on its side of the mean.
struct QuadBoxes {
  glm::vec2 mean;
  glm::vec2 same;      ///< reach in the quadrants with x*y > 0
  glm::vec2 opposite;  ///< reach in the quadrants with x*y < 0

  static QS_HD QuadBoxes of(const Footprint& footprint) {
    const Extents e = extents(footprint);
    const glm::vec2 minor(e.f * e.max.x, e.f * e.max.y);
    const bool major_is_same = footprint.conic.y < 0.0f;
    return {footprint.mean_px, major_is_same ? e.max : minor, major_is_same ? minor : e.max};
  }

  QS_HD glm::vec2 reach(int quadrant) const {
    return (quadrant == 0 || quadrant == 3) ? same : opposite;
  }

  /// Tiles of the box in quadrant 0 (-,-), 1 (+,-), 2 (-,+), 3 (+,+).
  template <int kTilePx = kTileSize>
  QS_HD TileRect tiles(int quadrant, TileGrid grid) const {
    const glm::vec2 r = reach(quadrant);
    const bool right = (quadrant & 1) != 0, below = (quadrant & 2) != 0;
    return {tiles_meeting<kTilePx>(right ? mean.x : mean.x - r.x, right ? mean.x + r.x : mean.x,
                                   grid.columns),
            tiles_meeting<kTilePx>(below ? mean.y : mean.y - r.y, below ? mean.y + r.y : mean.y,
                                   grid.rows)};
  }
};

/// QPass. Coordinate `u` runs along a line, `v` across lines.
template <int kTilePx>
struct QuadBoxWalk {
  bool by_rows;
  Span lines;
  int limit;  ///< tiles in a line
  float mean_u, mean_v;
  glm::vec2 same, opposite;  ///< (u, v) reach, see QuadBoxes

  static QS_HD QuadBoxWalk over(const QuadBoxes& boxes, const TileRect& range, TileGrid grid) {
    if (walks_rows(range))
      return {true,         range.rows, grid.columns,  boxes.mean.x,
              boxes.mean.y, boxes.same, boxes.opposite};
    return {false,
            range.columns,
            grid.rows,
            boxes.mean.y,
            boxes.mean.x,
            {boxes.same.y, boxes.same.x},
            {boxes.opposite.y, boxes.opposite.x}};
  }

  QS_HD Span span(int line) const {
    const float low = static_cast<float>(line * kTilePx), high = low + kTilePx;
    // True if the line meets the boxes before or after the mean.
    const bool before = low < mean_v;
    const bool after = high > mean_v;
    const bool same_before = before && high > mean_v - same.y;
    const bool opposite_before = before && high > mean_v - opposite.y;
    const bool same_after = after && low < mean_v + same.y;
    const bool opposite_after = after && low < mean_v + opposite.y;
    // Quadrants: (-,-) and (+,+) are `same`, (+,-) and (-,+) are `opposite`.
    const float left_same = same_before ? same.x : 0.0f,
                left_opposite = opposite_after ? opposite.x : 0.0f;
    const float right_same = same_after ? same.x : 0.0f,
                right_opposite = opposite_before ? opposite.x : 0.0f;
    const float left = left_same > left_opposite ? left_same : left_opposite;
    const float right = right_same > right_opposite ? right_same : right_opposite;
    return tiles_meeting<kTilePx>(mean_u - left, mean_u + right, limit);
  }

  QS_HD Span widest() const {
    const float reach = same.x > opposite.x ? same.x : opposite.x;
    return tiles_meeting<kTilePx>(mean_u - reach, mean_u + reach, limit);
  }
};

struct QuadBox {
  static constexpr const char* kName = "quadbox";

  template <int kTilePx = kTileSize>
  static QS_HD QuadBoxWalk<kTilePx> walk(const Footprint& footprint, TileGrid grid) {
    const QuadBoxes boxes = QuadBoxes::of(footprint);
    const glm::vec2 outer = glm::max(boxes.same, boxes.opposite);
    return QuadBoxWalk<kTilePx>::over(boxes, tiles_of_box<kTilePx>(boxes.mean, outer, grid), grid);
  }
};

struct QuadBoxNaive {
  static constexpr const char* kName = "quadbox-naive";
  using SameTiles = QuadBox;  ///< lists the same tiles, so counting needs no loop over boxes

  /// Calls visit(column, row) for the tiles within `window`, box by box, without the tiles that an
  /// earlier box contains.
  template <int kTilePx = kTileSize, class Visit>
  static QS_HD void for_each_tile_in(const Footprint& footprint, TileGrid grid,
                                     const TileRect& window, Visit&& visit) {
    const QuadBoxes boxes = QuadBoxes::of(footprint);
    const TileRect a = boxes.tiles<kTilePx>(0, grid), b = boxes.tiles<kTilePx>(1, grid);
    const TileRect c = boxes.tiles<kTilePx>(2, grid), d = boxes.tiles<kTilePx>(3, grid);
    loop(intersection(a, window), visit, [](int, int) { return false; });
    loop(intersection(b, window), visit, [&](int x, int y) { return a.contains(x, y); });
    loop(intersection(c, window), visit,
         [&](int x, int y) { return a.contains(x, y) || b.contains(x, y); });
    loop(intersection(d, window), visit,
         [&](int x, int y) { return a.contains(x, y) || b.contains(x, y) || c.contains(x, y); });
  }

  template <int kTilePx = kTileSize>
  static QS_HD TileRect bounds(const Footprint& footprint, TileGrid grid) {
    return qs::bounds<QuadBox, kTilePx>(footprint, grid);
  }

 private:
  template <class Visit, class Listed>
  static QS_HD void loop(const TileRect& rect, Visit& visit, const Listed& listed) {
    for (int row = rect.rows.begin; row < rect.rows.end; ++row)
      for (int column = rect.columns.begin; column < rect.columns.end; ++column)
        if (!listed(column, row)) visit(column, row);
  }
};

}  // namespace qs
