// SPDX-License-Identifier: MIT
//
// Stage 3: pairs by tile, then by depth, ties by index in the cloud; and where each tile's list
// lies among them.
#pragma once

#include "raster/cuda/classic/bin.cuh"

namespace qs::cuda {

struct TileLists {
  DeviceBuffer<uint2> ranges;  ///< per tile: its list is pairs [x, y)
};

void sort(const FrameContext& frame, TilePairs& pairs, TileLists& lists);

}  // namespace qs::cuda
