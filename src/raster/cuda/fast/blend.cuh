// SPDX-License-Identifier: MIT
//
// Stage 4 of the fast pipeline. A warp composites one half of a tile, 16x8 pixels, on its own. It
// takes the tile's list in batches, tests every Gaussian against each of its four sub-tiles of 8x4
// pixels, and queues it for those that it reaches. A quarter of the warp then works through the
// queue of each sub-tile: a lane owns a column of four pixels. Four sub-tiles advance at once, each
// with Gaussians of its own, so few operations are spent on pixels that a Gaussian does not reach.
#pragma once

#include "raster/cuda/fast/sort.cuh"
#include "raster/cuda/pixels.cuh"

namespace qs::cuda::fast {

/// Fills the maps that `outputs` asks for, and Counters::max_pairs_in_a_tile.
void blend(const FrameContext& frame, const Visible& visible, const TilePairs& pairs,
           const Scratch& scratch, const Outputs& outputs, Pixels& pixels);

}  // namespace qs::cuda::fast
