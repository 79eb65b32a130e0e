// SPDX-License-Identifier: MIT
//
// Mode `snugbox`: the SnugBox of Speedy-Splat (Hanson et al., arXiv 2412.00578). The level set
// alpha = 1/255 is the ellipse a x^2 + 2b x y + c y^2 = t with t = 2 ln(255 opacity). Its extreme
// coordinates follow from solving the equation for one coordinate and setting the derivative to
// zero. In real arithmetic this is the box of `adr`. Here the box is computed from the conic, as in
// the paper, and without the widening of extents(), so b^2 - ac cancels on needles.
#pragma once

#include "raster/kernel/cull/culler.h"

namespace qs {

struct SnugBox {
  static constexpr const char* kName = "snugbox";

  /// The |v| at which u is largest on p u^2 + 2b u v + r v^2 = t.
  static QS_HD float v_at_largest_u(float p, float b, float r, float t) {
    return sqrtf(-(b * b * t) / ((b * b - p * r) * r));
  }

  /// The largest u on that ellipse. NaN if rounding broke the ellipse: then no tile is listed.
  static QS_HD float largest_u(float p, float b, float r, float t) {
    const float v = v_at_largest_u(p, b, r, t);
    return (fabsf(b) * v + sqrtf((b * b - p * r) * v * v + t * p)) / p;
  }

  static QS_HD glm::vec2 half_extents(const Footprint& footprint) {
    const glm::vec3 q = footprint.conic;
    return {largest_u(q.x, q.y, q.z, footprint.gamma), largest_u(q.z, q.y, q.x, footprint.gamma)};
  }

  template <int kTilePx = kTileSize>
  static QS_HD RectWalk walk(const Footprint& footprint, TileGrid grid) {
    return RectWalk::over(tiles_of_box<kTilePx>(footprint.mean_px, half_extents(footprint), grid));
  }
};

}  // namespace qs
