// SPDX-License-Identifier: MIT
//
// The optimizer on the GPU: Adam for all parameters, with a learning rate for each kind, and the
// terms that strategy mcmc adds before and after the step. The coefficients of colour have a step
// of their own, which the projection of the next view need not wait for. It computes their
// gradients from the gradient of the colour, so these are never stored.
#pragma once

#include <cstdint>
#include <optional>

#include "learn/step/cuda/parameters.cuh"
#include "learn/step/training_model.h"

namespace qs::cuda::train {

using namespace qs::train;

/// Adam's moments, one per value of the parameters, and the number of steps so far.
struct AdamState {
  Parameters first, second;
  std::uint64_t steps = 0, rest_steps = 0;
  int sh_degree = 0;  ///< the moments of higher coefficients are zero
};

/// Gradients since the last step, see StepOrder::sums: of the coefficients of colour beyond DC, and
/// of all other values.
struct GradientSums {
  Parameters by;
  bool has_rest = false, has_others = false;  ///< false: the values are undefined, and count as 0

  bool empty() const { return !has_rest && !has_others; }
};

/// One step of all parameters but the coefficients of colour, and the noise after it. All arguments
/// have the same Gaussians. Sparsity adds its share to `gradient`.
void take_step(const StepOrder& order, Parameters& parameters, Parameters& gradient,
               AdamState& state, cudaStream_t stream);

/// The coefficients' share of the same step, after take_step(), if the order moves parameters. If
/// it sums gradients, `sums` has them.
void take_color_step(const StepOrder& order, Parameters& parameters, const Gradients& gradients,
                     GradientSums& sums, AdamState& state, cudaStream_t stream);

/// Adds gradients to the sums of take_step(), and to the sums of take_color_step(); does nothing
/// for values whose step needs no sums. `sums.by` has the Gaussians of the gradients.
void add_gradients(const StepOrder& order, Gradients& gradients, GradientSums& sums,
                   cudaStream_t stream);
void add_color_gradients(const StepOrder& order, const Gradients& gradients, GradientSums& sums,
                         cudaStream_t stream);

}  // namespace qs::cuda::train
