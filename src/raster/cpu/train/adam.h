// SPDX-License-Identifier: MIT
//
// The optimizer: Adam for all parameters, with a learning rate for each kind.
#pragma once

#include "raster/base/parallel.h"
#include "raster/cpu/train/parameters.h"
#include "raster/kernel/adam.h"

namespace qs::cpu::train {

using qs::Rates;
using qs::train::AdamState;

/// One step. All arguments have the same Gaussians.
void take_step(Parameters<float>& parameters, const Parameters<float>& gradient, const Rates& rates,
               AdamState& state, ThreadPool& pool);

}  // namespace qs::cpu::train
