// SPDX-License-Identifier: MIT
//
// Copies counts, and the requested maps and trace, from the tile lists into the frame.
#pragma once

#include <functional>

#include "raster/cpu/common/tile_lists.h"
#include "raster/cpu/common/visible.h"
#include "raster/kernel/blend.h"

namespace qs::cpu {

/// The Gaussian in a slot as the blend stage sees it.
using SplatOf = std::function<Splat(std::uint32_t slot)>;

/// Fills stats, pairs and trace of `result`. result.grid and result.used are already set.
void collect(const VisibleSlots& visible, const TileLists& lists, const SplatOf& splat_of,
             const Outputs& outputs, Frame& result);

}  // namespace qs::cpu
