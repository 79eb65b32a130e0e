// SPDX-License-Identifier: MIT
//
// Stage 2 of the fast pipeline: lists one (tile, Gaussian) pair for every tile that the culling
// mode assigns to a visible Gaussian, with the Gaussians in front-to-back order.
#pragma once

#include "raster/cuda/fast/sort.cuh"

namespace qs::cuda::fast {

/// Also counts the pairs, and the digits of their keys for the following sort. Pairs beyond
/// size.pair_capacity are counted but not written.
void bin(const FrameContext& frame, const FrameSize& size, Visible& visible,
         const DepthOrder& order, Scratch& scratch, TilePairs& pairs);

}  // namespace qs::cuda::fast
