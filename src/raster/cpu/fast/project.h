// SPDX-License-Identifier: MIT
//
// kernel/footprint.h's project() for a block at a time, bit for bit (a test compares them).
#pragma once

#include "raster/cpu/fast/survivors.h"

namespace qs::cpu::fast {

/// Fills every plane of `out` but the colours with the Gaussians of `block` that have a footprint.
/// `first` is the cloud's index of the block's first Gaussian.
void project(const View<float>& view, const FootprintRules& rules, const Block& block,
             std::uint32_t first, Survivors& out);

}  // namespace qs::cpu::fast
