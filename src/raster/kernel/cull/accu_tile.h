// SPDX-License-Identifier: MIT
//
// Mode `accutile`: the AccuTile of Speedy-Splat (Hanson et al., arXiv 2412.00578). It walks the
// tiles of the SnugBox along their shorter side. In each line, the ellipse spans the tiles between
// its smallest and its largest coordinate there. These are at the line's two borders, or at the
// ellipse's own extremes if they are between the borders. A tile is the square between its borders;
// `exact` takes the smaller square of its pixel centres.
#pragma once

#include "raster/kernel/cull/snug_box.h"

namespace qs {

/// Coordinates as in QuadBoxWalk: `u` along a line, `v` across lines; p u^2 + 2b u v + r v^2 = t.
template <int kTilePx>
struct AccuTileWalk {
  bool by_rows;
  Span lines;
  Span box;  ///< tiles of the SnugBox in a line
  float mean_u, mean_v;
  float p, b, r, t;
  float v_max;
  float v_at_u_max;

  QS_HD Span span(int line) const {
    const float low = static_cast<float>(line * kTilePx) - mean_v;
    const float high = low + kTilePx;
    const float v0 = low > -v_max ? low : -v_max;
    const float v1 = high < v_max ? high : v_max;
    if (!(v0 <= v1)) return {0, 0};
    const float left = u_at(clamped(-v_at_u_max, v0, v1), -1.0f);
    const float right = u_at(clamped(v_at_u_max, v0, v1), 1.0f);
    return intersection(tiles_meeting<kTilePx>(mean_u + left, mean_u + right, box.end), box);
  }
  QS_HD Span widest() const { return box; }

 private:
  QS_HD float u_at(float v, float sign) const {
    const float under = (b * b - p * r) * v * v + t * p;
    return (sign * sqrtf(under > 0.0f ? under : 0.0f) - b * v) / p;
  }
};

struct AccuTile {
  static constexpr const char* kName = "accutile";

  template <int kTilePx = kTileSize>
  static QS_HD AccuTileWalk<kTilePx> walk(const Footprint& footprint, TileGrid grid) {
    const glm::vec2 half = SnugBox::half_extents(footprint);
    const RectWalk box = RectWalk::over(tiles_of_box<kTilePx>(footprint.mean_px, half, grid));
    const glm::vec3 q = footprint.conic;
    const glm::vec2 mean = footprint.mean_px;
    AccuTileWalk<kTilePx> walk{};
    walk.by_rows = box.by_rows;
    walk.lines = box.lines;
    walk.box = box.tiles;
    walk.mean_u = box.by_rows ? mean.x : mean.y;
    walk.mean_v = box.by_rows ? mean.y : mean.x;
    walk.p = box.by_rows ? q.x : q.z;
    walk.b = q.y;
    walk.r = box.by_rows ? q.z : q.x;
    walk.t = footprint.gamma;
    walk.v_max = box.by_rows ? half.y : half.x;
    const float v = SnugBox::v_at_largest_u(walk.p, walk.b, walk.r, walk.t);
    walk.v_at_u_max = walk.b > 0.0f ? -v : v;
    return walk;
  }
};

}  // namespace qs
