// SPDX-License-Identifier: MIT
//
// project() of kernel/footprint.h for a block at a time. A test compares the results bit for bit.
#pragma once

#include "raster/cpu/fast/survivors.h"
#include "raster/kernel/frustum.h"

namespace qs::cpu::fast {

/// Fills `out` with the Gaussians of `block` that have a footprint, except Gaussians too far
/// outside of the image to have a tile in any mode.
void project(const View<float>& view, const FootprintRules& rules, TileGrid grid,
             const Block& block, Survivors& out);

}  // namespace qs::cpu::fast
