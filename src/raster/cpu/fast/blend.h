// SPDX-License-Identifier: MIT
//
// Stage 4: composites every tile's list, front to back, a row of pixels at a time.
#pragma once

#include "raster/cpu/fast/preprocess.h"
#include "raster/cpu/tile_lists.h"

namespace qs::cpu::fast {

/// Fills the maps of `result` that `outputs` asks for (color, evaluated); they are already sized.
void blend(const FrameContext& frame, const Visible& visible, const TileLists& lists,
           const Outputs& outputs, Frame& result);

}  // namespace qs::cpu::fast
