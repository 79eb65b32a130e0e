// SPDX-License-Identifier: MIT
//
// Stage 4: composites every tile's list front to back. Maps that need more than colours composite
// the lists again.
#pragma once

#include "raster/cpu/classic/preprocess.h"
#include "raster/cpu/common/bin.h"

namespace qs::cpu {

/// Fills color and evaluated of `result` if requested. They already have their sizes.
void blend(const FrameContext& frame, const Visible& visible, const TileLists& lists,
           const Outputs& outputs, Frame& result);

/// Fills result.depth, whose maps already have their sizes.
void draw_depth(const FrameContext& frame, const Visible& visible, const TileLists& lists,
                Frame& result);

/// Fills result.used: per tile, the pairs that at least one pixel blends.
void count_used(const FrameContext& frame, const Visible& visible, const TileLists& lists,
                Frame& result);

}  // namespace qs::cpu
