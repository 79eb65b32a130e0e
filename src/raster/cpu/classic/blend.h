// SPDX-License-Identifier: MIT
//
// Stage 4: composites every tile's list front to back.
#pragma once

#include "raster/cpu/classic/preprocess.h"
#include "raster/cpu/common/bin.h"

namespace qs::cpu {

/// Fills color and evaluated of `result` if requested. They already have their sizes.
void blend(const FrameContext& frame, const Visible& visible, const TileLists& lists,
           const Outputs& outputs, Frame& result);

}  // namespace qs::cpu
