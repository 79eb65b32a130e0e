// SPDX-License-Identifier: MIT
//
// Stage 4 of the fast pipeline. A warp composites one half of a tile, 16x8 pixels, on its own. It
// takes the tile's list in batches, tests every Gaussian against its two sub-tiles of 8x8 pixels,
// and queues it for those that it reaches. Half a warp then works through the queue of each
// sub-tile, a lane on four pixels: the two advance at once, each with Gaussians of its own, so that
// fewer operations are spent on pixels that a Gaussian does not reach.
#pragma once

#include "raster/cuda/fast/sort.cuh"
#include "raster/cuda/pixels.cuh"

namespace qs::cuda::fast {

/// Fills the maps that `outputs` asks for.
void blend(const FrameContext& frame, const Visible& visible, const TilePairs& pairs,
           const Scratch& scratch, const Outputs& outputs, Pixels& pixels);

}  // namespace qs::cuda::fast
