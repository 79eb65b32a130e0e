// SPDX-License-Identifier: MIT
//
// kernel/footprint.h's project() for a block at a time, bit for bit (a test compares them).
#pragma once

#include "raster/cpu/fast/survivors.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cpu::fast {

/// Fills `out` with the Gaussians of `block` that have a footprint, without those that are too far
/// outside the picture to have a tile in any mode.
void project(const View<float>& view, const FootprintRules& rules, TileGrid grid,
             const Block& block, Survivors& out);

}  // namespace qs::cpu::fast
