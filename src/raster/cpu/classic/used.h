// SPDX-License-Identifier: MIT
//
// Counts the pairs that a pixel blended, for frames that request Outputs::used. It composites every
// pixel again after the blend stage.
#pragma once

#include "raster/cpu/classic/preprocess.h"
#include "raster/cpu/common/bin.h"

namespace qs::cpu {

/// Fills result.used.
void count_used(const FrameContext& frame, const Visible& visible, const TileLists& lists,
                Frame& result);

}  // namespace qs::cpu
