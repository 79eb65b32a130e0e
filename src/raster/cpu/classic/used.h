// SPDX-License-Identifier: MIT
//
// Which listed pairs were worth listing: a pass of its own after blending, for frames that ask for
// Outputs::used. It composites every pixel again, so that blending need not know of it.
#pragma once

#include "raster/cpu/classic/bin.h"

namespace qs::cpu {

/// Fills result.used, per tile.
void count_used(const FrameContext& frame, const Visible& visible, const TileLists& lists,
                Frame& result);

}  // namespace qs::cpu
