// SPDX-License-Identifier: MIT
//
// The optimizer on the GPU: Adam for all parameters, with a learning rate for each kind, in one
// kernel, and the terms that strategy mcmc adds before and after the step.
#pragma once

#include <cstdint>
#include <optional>

#include "raster/api/training_model.h"
#include "raster/cuda/train/parameters.cuh"

namespace qs::cuda::train {

using qs::train::StepOrder;

/// Adam's moments, one per value of the parameters, and the number of steps so far.
struct AdamState {
  Parameters first, second;
  std::uint64_t steps = 0;
};

/// One step, and the noise after it. All arguments have the same Gaussians. Sparsity adds its share
/// to `gradient`.
void take_step(const StepOrder& order, Parameters& parameters, Parameters& gradient,
               AdamState& state, cudaStream_t stream);

}  // namespace qs::cuda::train
