// SPDX-License-Identifier: MIT
//
// The end of an iteration: the optimizer, which is Adam for all parameters, with a learning rate
// for each kind, and the statistics of adaptive density control.
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.h"
#include "learn/gradient/adam.h"
#include "learn/step/cpu/parameters.h"

namespace qs::cpu::train {

/// One step. All arguments have the same Gaussians. `moves_rest`: also of the coefficients of
/// colour beyond DC.
void take_step(Parameters<float>& parameters, const Parameters<float>& gradient, const Rates& rates,
               AdamState& state, ThreadPool& pool, bool moves_rest = true);

/// Adds `gradient` to `sums`, which may be empty.
void add_gradients(const Parameters<float>& gradient, ThreadPool& pool, Parameters<float>& sums);

/// Sets the sums that a step has used to 0. If that is all of them, `sums` becomes empty.
void clear_sums(bool rest_too, Parameters<float>& sums);

/// Adds a view of `width` x `height` pixels, with absolute gradients if `gradients` has them.
/// `counted` is 1 for the Gaussians that it counts for.
void add_view(const Gradients<float>& gradients, std::span<const std::uint8_t> counted, int width,
              int height, DensityStatistics& statistics);

}  // namespace qs::cpu::train
