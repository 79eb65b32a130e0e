// SPDX-License-Identifier: MIT
//
// Stage 2 of the fast pipeline: one (tile, Gaussian) pair for every tile that the mode gives a
// visible Gaussian, Gaussians front to back.
#pragma once

#include "raster/cuda/fast/sort.cuh"

namespace qs::cuda::fast {

/// Also counts the pairs, and the digits of their keys for the sort that follows. Pairs beyond
/// size.pairs are counted and not written.
void bin(const FrameContext& frame, const FrameSize& size, Visible& visible,
         const DepthOrder& order, Scratch& scratch, TilePairs& pairs);

}  // namespace qs::cuda::fast
