// SPDX-License-Identifier: MIT
//
// Stage 4: composites every tile's list, front to back.
#pragma once

#include "raster/cpu/classic/bin.h"

namespace qs::cpu {

/// Fills the maps of `result` that `outputs` asks for (color, evaluated); they are already sized.
void blend(const FrameContext& frame, const Visible& visible, const TileLists& lists,
           const Outputs& outputs, Frame& result);

}  // namespace qs::cpu
