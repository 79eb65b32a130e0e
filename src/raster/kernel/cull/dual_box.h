// SPDX-License-Identifier: MIT
//
// Mode `dualbox`: only the two quadrant boxes along the major axis, the ablation of QuadBox (ICIP
// 2026). It loses the parts of the ellipse in the two other quadrants.
#pragma once

#include "raster/kernel/cull/quad_box.h"

namespace qs {

struct DualBox {
  static constexpr const char* kName = "dualbox";

  template <int kTilePx = kTileSize>
  static QS_HD QuadBoxWalk<kTilePx> walk(const Footprint& footprint, TileGrid grid) {
    const glm::vec2 max = extents(footprint).max;
    const bool major_is_same = footprint.conic.y < 0.0f;
    const glm::vec2 none(0.0f);
    const QuadBoxes boxes{footprint.mean_px, major_is_same ? max : none,
                          major_is_same ? none : max};
    return QuadBoxWalk<kTilePx>::over(boxes, tiles_of_box<kTilePx>(boxes.mean, max, grid), grid);
  }
};

}  // namespace qs
