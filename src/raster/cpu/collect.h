// SPDX-License-Identifier: MIT
//
// What a frame tells of its lists: numbers always, maps and trace when asked for.
#pragma once

#include "raster/cpu/tile_lists.h"
#include "raster/cpu/visible.h"

namespace qs::cpu {

/// Fills stats, pairs and trace of `result`; result.grid is set.
void collect(const VisibleSlots& visible, const TileLists& lists, const Outputs& outputs,
             Frame& result);

}  // namespace qs::cpu
