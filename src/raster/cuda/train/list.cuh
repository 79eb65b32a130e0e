// SPDX-License-Identifier: MIT
//
// The pairs of tiles and Gaussians of a training step. Pairs are written in the order of ranks
// (DepthOrder), then of tiles, in every culling mode, so that a pair's index before sorting is its
// place. A warp shares the tiles of a large Gaussian.
#pragma once

#include "raster/cuda/train/forward.cuh"

namespace qs::cuda::train {

/// Fills frame.pairs for `count` Gaussians, from frame.footprints and frame.order. Waits once, for
/// the number of pairs. Throws Cancelled, and Error(device) if memory is short.
void list_pairs(const StepView& view, std::uint32_t count, ForwardFrame& frame);

}  // namespace qs::cuda::train
