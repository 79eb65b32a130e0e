// SPDX-License-Identifier: MIT
//
// Alpha and depth of a frame that requests Outputs::depth. It composites every pixel again after
// the blend stage.
#pragma once

#include "raster/cpu/classic/preprocess.h"
#include "raster/cpu/common/bin.h"

namespace qs::cpu {

/// Fills result.depth, whose maps already have their sizes.
void draw_depth(const FrameContext& frame, const Visible& visible, const TileLists& lists,
                Frame& result);

}  // namespace qs::cpu
