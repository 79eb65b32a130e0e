// SPDX-License-Identifier: MIT
//
// The optimizer: Adam for all parameters, with a learning rate for each kind.
#pragma once

#include <cstdint>

#include "raster/base/parallel.h"
#include "raster/cpu/train/parameters.h"

namespace qs::cpu::train {

struct Rates {
  double mean = 0, log_scale = 0, rotation = 0, opacity = 0, sh_dc = 0, sh_rest = 0;
};

/// Adam's moments, for Gaussians like those of the parameters, and the number of steps so far.
struct AdamState {
  Parameters<float> first, second;
  std::uint64_t steps = 0;

  /// Zero moments for the Gaussians of `parameters`.
  static AdamState like(const Parameters<float>& parameters);
};

/// One step. All arguments have the same Gaussians.
void take_step(Parameters<float>& parameters, const Parameters<float>& gradient, const Rates& rates,
               AdamState& state, ThreadPool& pool);

}  // namespace qs::cpu::train
