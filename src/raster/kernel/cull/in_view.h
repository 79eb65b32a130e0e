// SPDX-License-Identifier: MIT
//
// The rule for the views in which adaptive density control counts a Gaussian.
#pragma once

#include "raster/kernel/cull/exact.h"

namespace qs {

/// True if mode `exact` lists the Gaussian in a tile, so the statistics do not depend on the
/// culling mode of the frame. The published code also counts views in which only the square of 3
/// standard deviations meets the image. The Gaussian is invisible in these views and has no
/// gradient.
QS_HD bool is_in_view(const Footprint& footprint, TileGrid grid) {
  return footprint.gamma > 0.0f && lists_a_tile<Exact>(footprint, grid);
}

}  // namespace qs
