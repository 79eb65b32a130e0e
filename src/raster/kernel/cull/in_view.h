// SPDX-License-Identifier: MIT
//
// In which views the statistics of adaptive density control count a Gaussian.
#pragma once

#include "raster/kernel/cull/exact.h"

namespace qs {

/// True if mode `exact` lists the Gaussian in a tile. So the statistics do not depend on the
/// culling mode of the frame. The published code also counts views in which only the square of 3
/// standard deviations meets the image. In these the Gaussian does not show and has no gradient.
QS_HD bool is_in_view(const Footprint& footprint, TileGrid grid) {
  return footprint.gamma > 0.0f && lists_a_tile<Exact>(footprint, grid);
}

}  // namespace qs
