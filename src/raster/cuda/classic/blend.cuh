// SPDX-License-Identifier: MIT
//
// Stage 4 of the classic pipeline: composites the list of every tile, front to back. A tile is one
// block with one thread per pixel; it loads its list in batches of one Gaussian per thread.
#pragma once

#include "raster/cuda/classic/sort.cuh"
#include "raster/cuda/common/pixels.cuh"

namespace qs::cuda::classic {

/// Fills the parts of `pixels` that `outputs` requests, and ClassicCounters::max_pairs_in_a_tile.
void blend(const FrameContext& frame, ClassicVisible& visible, const ClassicPairs& pairs,
           const TileLists& lists, const Outputs& outputs, Pixels& pixels);

}  // namespace qs::cuda::classic
