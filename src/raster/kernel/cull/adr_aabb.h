// SPDX-License-Identifier: MIT
//
// Mode `adr`: the tight axis-aligned bounding box of the level set alpha = 1/255
// (AdR-Gaussian 2024; Speedy-Splat's SnugBox 2025).
#pragma once

#include "raster/kernel/cull/culler.h"

namespace qs {

struct AdrAabb {
  static constexpr const char* kName = "adr";

  template <int kTilePx = kTileSize>
  static QS_HD RectWalk walk(const Footprint& footprint, TileGrid grid) {
    return RectWalk::over(tiles_of_box<kTilePx>(footprint.mean_px, extents(footprint).max, grid));
  }
};

}  // namespace qs
