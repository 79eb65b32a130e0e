// SPDX-License-Identifier: MIT
//
// The lists of tiles of a training step. Gaussians list their pairs in any order of their own, the
// pairs of each in the order of tiles, in every culling mode. A warp shares the tiles of a large
// Gaussian. Then the list of every tile is sorted by depth, then by the Gaussian's index, in the
// shared memory of a block, as pipeline `fast` sorts. So the order of the lists does not depend on
// the order in which threads run.
#pragma once

#include "raster/cuda/train/forward.cuh"

namespace qs::cuda::train {

/// Fills frame.pairs and frame.lists for `count` projected Gaussians. The host waits for the number
/// of pairs, while the GPU lists: it lists again if the memory was too small for the pairs. Throws
/// Cancelled, and Error(device) if memory is short.
void list_view(const StepView& view, std::uint32_t count, ForwardFrame& frame);

}  // namespace qs::cuda::train
