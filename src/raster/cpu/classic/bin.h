// SPDX-License-Identifier: MIT
//
// Stage 3 of the CPU backend: every visible Gaussian into the lists of the tiles that the mode
// gives it.
#pragma once

#include "raster/cpu/classic/sort.h"
#include "raster/cpu/tile_lists.h"

namespace qs::cpu {

/// Throws Error(device) when the lists do not fit into memory.
void bin(const FrameContext& frame, const Visible& visible, const DepthOrder& order,
         TileLists& lists);

}  // namespace qs::cpu
