// SPDX-License-Identifier: MIT
//
// Stage 3: lists every visible Gaussian in its tiles, in one pass front to back.
#pragma once

#include "raster/cpu/common/tile_lists.h"
#include "raster/cpu/fast/preprocess.h"
#include "raster/cpu/fast/sort.h"

namespace qs::cpu::fast {

/// Throws Error(device) if the lists do not fit into memory.
void bin(const FrameContext& frame, const FastVisible& visible, const Bands& bands,
         TileLists& lists);

}  // namespace qs::cpu::fast
