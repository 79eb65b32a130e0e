// SPDX-License-Identifier: MIT
//
// Stage 4 of the fast pipeline. Every warp composites half a tile, 16x8 pixels, independently. It
// reads the tile's list in batches, tests every Gaussian against its four sub-tiles of 8x4 pixels,
// and appends it to the queues of those it overlaps. Eight lanes then process the queue of each
// sub-tile, four pixels per lane. The four queues advance in parallel with different Gaussians, so
// that little work is spent on pixels that a Gaussian does not overlap.
#pragma once

#include "raster/cuda/fast/sort.cuh"
#include "raster/cuda/pixels.cuh"

namespace qs::cuda::fast {

/// Fills the parts of `pixels` that `outputs` requests.
void blend(const FrameContext& frame, const Visible& visible, const TilePairs& pairs,
           const Scratch& scratch, const Outputs& outputs, Pixels& pixels);

}  // namespace qs::cuda::fast
