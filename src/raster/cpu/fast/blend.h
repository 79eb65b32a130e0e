// SPDX-License-Identifier: MIT
//
// Stage 4: composites every tile's list, front to back, a cell of 4x4 pixels at a time.
#pragma once

#include "raster/cpu/fast/bin.h"

namespace qs::cpu::fast {

/// The order in which tiles are composited.
struct TileQueue {
  Array<std::uint32_t> tiles;
};

/// Fills the maps of `result` that `outputs` asks for (color, evaluated); they are already sized.
void blend(const FrameContext& frame, const Visible& visible, const TileLists& lists,
           TileQueue& queue, const Outputs& outputs, Frame& result);

}  // namespace qs::cpu::fast
