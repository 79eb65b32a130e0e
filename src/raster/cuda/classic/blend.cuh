// SPDX-License-Identifier: MIT
//
// Stage 4: composites every tile's list, front to back. One block per tile, one thread per pixel;
// the block reads the list in batches of as many Gaussians as it has threads.
#pragma once

#include "raster/cuda/classic/sort.cuh"
#include "raster/cuda/pixels.cuh"

namespace qs::cuda {

/// Fills the maps that `outputs` asks for, and Counters::max_pairs_in_a_tile.
void blend(const FrameContext& frame, Visible& visible, const TilePairs& pairs,
           const TileLists& lists, const Outputs& outputs, Pixels& pixels);

}  // namespace qs::cuda
