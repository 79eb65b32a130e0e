// SPDX-License-Identifier: MIT
//
// Mode `faster-gs`: the exact tile count of Faster-GS (Hahlbohm et al., arXiv 2602.09999). It lists
// the tiles in a tight, opacity-aware bounding box that pass StopThePop's tile test. The paper
// applies the test already when it counts tiles, so it counts only tiles with a contribution and
// sorts no empty entry. In real arithmetic the mode lists the tiles of `stopthepop` from fewer
// candidates.
#pragma once

#include "raster/kernel/cull/stop_the_pop.h"

namespace qs {

struct FasterGs {
  static constexpr const char* kName = "faster-gs";

  template <int kTilePx = kTileSize>
  static QS_HD TestedWalk<LargestAlphaTest<kTilePx>> walk(const Footprint& footprint,
                                                          TileGrid grid) {
    return TestedWalk<LargestAlphaTest<kTilePx>>::over(
        tiles_of_plain_box<kTilePx>(footprint, grid),
        {footprint.mean_px, footprint.conic, footprint.gamma});
  }
};

}  // namespace qs
