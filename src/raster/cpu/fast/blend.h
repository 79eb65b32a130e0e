// SPDX-License-Identifier: MIT
//
// Stage 4: composites every tile's list front to back.
#pragma once

#include "raster/cpu/fast/bin.h"

namespace qs::cpu::fast {

/// The order in which tiles are composited.
struct TileQueue {
  Array<std::uint32_t> tiles;
};

/// Fills color and evaluated of `result` if requested. They already have their sizes.
void blend(const FrameContext& frame, const FastVisible& visible, const TileLists& lists,
           TileQueue& queue, const Outputs& outputs, Frame& result);

}  // namespace qs::cpu::fast
