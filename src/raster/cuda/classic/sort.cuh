// SPDX-License-Identifier: MIT
//
// Stage 3 of the classic pipeline: sorts the pairs by tile, then by depth, then by index in the
// cloud, and finds the range of every tile's list.
#pragma once

#include "raster/cuda/classic/bin.cuh"
#include "raster/cuda/common/pixels.cuh"

namespace qs::cuda::classic {

struct TileLists {
  DeviceBuffer<ListRange> ranges;  ///< per tile: its list in the pairs
};

void sort(const FrameContext& frame, ClassicPairs& pairs, TileLists& lists);

}  // namespace qs::cuda::classic
