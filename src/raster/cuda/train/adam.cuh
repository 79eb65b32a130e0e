// SPDX-License-Identifier: MIT
//
// The optimizer on the GPU: Adam for all parameters, with a learning rate for each kind, and the
// terms that strategy mcmc adds before and after the step. The coefficients of colour have a step
// of their own, which the projection of the next view need not wait for. It computes their
// gradients from the gradient of the colour, so these are never stored.
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
  int sh_degree = 0;  ///< the moments of higher coefficients are zero
};

/// One step of all parameters but the coefficients of colour, and the noise after it. All arguments
/// have the same Gaussians. Sparsity adds its share to `gradient`.
void take_step(const StepOrder& order, Parameters& parameters, Parameters& gradient,
               AdamState& state, cudaStream_t stream);

/// The coefficients' share of the same step, after take_step(), if the order moves parameters.
void take_color_step(const StepOrder& order, Parameters& parameters, const Gradients& gradients,
                     AdamState& state, cudaStream_t stream);

}  // namespace qs::cuda::train
