// SPDX-License-Identifier: MIT
//
// Counts views in the statistics of adaptive density control.
#pragma once

#include <cstdint>
#include <span>

#include "learn/step/cpu/parameters.h"

namespace qs::cpu::train {

/// Adds a view of `width` x `height` pixels, with absolute gradients if `gradients` has them.
/// `counted` is 1 for the Gaussians that it counts for.
void add_view(const Gradients<float>& gradients, std::span<const std::uint8_t> counted, int width,
              int height, DensityStatistics& statistics);

}  // namespace qs::cpu::train
