// SPDX-License-Identifier: MIT
//
// The lists of tiles of a training step, see list_pairs().
#pragma once

#include "learn/step/cuda/forward.cuh"

namespace qs::cuda::train {

/// Fills frame.pairs and frame.lists for `count` projected Gaussians. The host waits for the number
/// of pairs, while the GPU lists: it lists again if the memory was too small for the pairs. Throws
/// Cancelled, and Error(device) if memory is short.
void list_view(const StepView& view, std::uint32_t count, ForwardFrame& frame);

}  // namespace qs::cuda::train
