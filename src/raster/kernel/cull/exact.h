// SPDX-License-Identifier: MIT
//
// Mode `exact`: the lower bound. It lists a tile if its square of pixel centres meets the ellipse,
// with one closed-form span per line. Spans between pixel centres may be empty. Gamma is enlarged
// by kExactSlack and k of Extents against rounding. The span is clipped by QuadBox's, so that exact
// <= quadbox <= adr holds by construction.
#pragma once

#include "raster/kernel/cull/quad_box.h"

namespace qs {

/// Coordinates as in QuadBoxWalk: `u` along a line, `v` across lines.
template <int kTilePx>
struct ExactWalk {
  bool by_rows;
  Span lines;
  QuadBoxWalk<kTilePx> boxes;
  float gamma;       ///< enlarged
  float s_vv, s_uv;  ///< covariance in (u, v)
  float determinant;
  float v_max;       ///< sqrt(gamma s_vv)
  float v_at_u_max;  ///< v where the ellipse reaches its largest u: s_uv sqrt(gamma / s_uu)

  QS_HD Span span(int line) const {
    // The line's pixel centres within the ellipse, relative to the mean.
    const float low = static_cast<float>(line * kTilePx) - boxes.mean_v;
    const float high = low + (kTilePx - 1);
    const float v0 = low > -v_max ? low : -v_max;
    const float v1 = high < v_max ? high : v_max;
    if (v0 > v1) return {0, 0};
    // u(v) = (s_uv v +- sqrt((s_vv gamma - v^2) det)) / s_vv is concave / convex, so its extremes
    // over [v0, v1] are at the ellipse's own extremes or at the nearest end.
    const float right = u_at(clamped(v_at_u_max, v0, v1), 1.0f);
    const float left = u_at(clamped(-v_at_u_max, v0, v1), -1.0f);
    return intersection(
        tiles_with_centers<kTilePx>(boxes.mean_u + left, boxes.mean_u + right, boxes.limit),
        boxes.span(line));
  }

  QS_HD Span widest() const { return boxes.widest(); }

 private:
  QS_HD float u_at(float v, float sign) const {
    const float under = (s_vv * gamma - v * v) * determinant;
    return (s_uv * v + sign * sqrtf(under > 0.0f ? under : 0.0f)) / s_vv;
  }
};

struct Exact {
  static constexpr const char* kName = "exact";

  template <int kTilePx = kTileSize>
  static QS_HD ExactWalk<kTilePx> walk(const Footprint& footprint, TileGrid grid) {
    const Covariance2<float>& s = footprint.covariance;
    const float k = extents(footprint).k;
    ExactWalk<kTilePx> walk{};
    walk.boxes = QuadBox::walk<kTilePx>(footprint, grid);
    walk.by_rows = walk.boxes.by_rows;
    walk.lines = walk.boxes.lines;
    walk.gamma = footprint.gamma * kExactSlack * k * k;
    const float s_uu = walk.by_rows ? s.xx : s.yy;
    walk.s_vv = walk.by_rows ? s.yy : s.xx;
    walk.s_uv = s.xy;
    walk.determinant = footprint.determinant;
    walk.v_max = sqrtf(walk.gamma * walk.s_vv);
    walk.v_at_u_max = s.xy * sqrtf(walk.gamma / s_uu);
    return walk;
  }
};

}  // namespace qs
