// SPDX-License-Identifier: MIT
//
// What a frame tells of its lists: numbers always, maps and trace when asked for.
#pragma once

#include <functional>

#include "raster/cpu/tile_lists.h"
#include "raster/cpu/visible.h"
#include "raster/kernel/blend.h"

namespace qs::cpu {

/// What blending reads of the Gaussian in a slot.
using SplatOf = std::function<Splat(std::uint32_t slot)>;

/// Fills stats, pairs and trace of `result`; result.grid and result.used are set.
void collect(const VisibleSlots& visible, const TileLists& lists, const SplatOf& splat_of,
             const Outputs& outputs, Frame& result);

}  // namespace qs::cpu
