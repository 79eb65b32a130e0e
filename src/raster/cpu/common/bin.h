// SPDX-License-Identifier: MIT
//
// Stage 3: lists every visible Gaussian in the tiles that the culling mode assigns to it.
#pragma once

#include "raster/cpu/common/sort.h"
#include "raster/cpu/common/tile_lists.h"

namespace qs::cpu {

/// Throws Error(device) if the lists do not fit into memory.
void bin(const FrameContext& frame, const VisibleSlots& visible, const DepthOrder& order,
         TileLists& lists);

}  // namespace qs::cpu
