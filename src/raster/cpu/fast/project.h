// SPDX-License-Identifier: MIT
//
// project() of kernel/footprint.h for a block at a time. A test compares the results bit for bit.
#pragma once

#include "raster/cpu/fast/survivors.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cpu::fast {

/// No mode lists a tile further from the mean than k sqrt(level (Sxx + Syy)) + 2 tiles in pixels,
/// with k = kReachK + kReachKPerF2 / f^2 (see Extents) and level = max(gamma, kSigmas^2).
inline constexpr float kReachK = 1.01f, kReachKPerF2 = 3e-7f;

/// Fills `out` with the Gaussians of `block` that have a footprint, except those that are too far
/// outside of the image to have a tile in any mode.
void project(const View<float>& view, const FootprintRules& rules, TileGrid grid,
             const Block& block, Survivors& out);

}  // namespace qs::cpu::fast
