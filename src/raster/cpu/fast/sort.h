// SPDX-License-Identifier: MIT
//
// Stage 2: sorts the visible Gaussians of every band of tile rows front to back.
#pragma once

#include "raster/cpu/fast/bands.h"

namespace qs::cpu::fast {

/// Finds the bands and sorts their Gaussians by ascending (bits of the depth, index in the cloud).
void sort(const FrameContext& frame, const FastVisible& visible, Bands& bands);

}  // namespace qs::cpu::fast
