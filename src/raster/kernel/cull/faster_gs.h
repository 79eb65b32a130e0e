// SPDX-License-Identifier: MIT
//
// Mode `faster-gs`: the exact tile count of Faster-GS (Hahlbohm et al., arXiv 2602.09999).
// Implemented is the statement that the tiles of a tight, opacity-aware bounding box are tested by
// StopThePop's tile-based culling already when they are counted, so that the count is that of the
// tiles which receive a contribution, and no empty entry is sorted. In real arithmetic it lists the
// tiles of `stopthepop` from fewer candidates.
#pragma once

#include "raster/kernel/cull/stop_the_pop.h"

namespace qs {

struct FasterGs {
  static constexpr const char* kName = "faster-gs";
  static constexpr const char* kSummary =
      "Faster-GS: tiles in which alpha reaches 1/255, of a tight box, loses parts of needles";
  static constexpr bool kLossless = false;
  static constexpr bool kKeepsFaint = false;

  template <int kTilePx = kTileSize>
  static QS_HD TestedWalk<LargestAlphaTest<kTilePx>> walk(const Footprint& footprint,
                                                          TileGrid grid) {
    return TestedWalk<LargestAlphaTest<kTilePx>>::over(
        tiles_of_plain_box<kTilePx>(footprint, grid),
        {footprint.mean_px, footprint.conic, footprint.gamma});
  }
};

}  // namespace qs
