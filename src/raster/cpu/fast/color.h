// SPDX-License-Identifier: MIT
//
// kernel/sh.h's sh_color() for the Gaussians of a block that have tiles.
#pragma once

#include "raster/cpu/fast/survivors.h"

namespace qs::cpu::fast {

/// Per Gaussian of a block.
struct alignas(64) Colors {
  float red[kBlock], green[kBlock], blue[kBlock];
};

/// Fills the colours of the survivors of block `index`, and of some of their neighbours.
/// `view_position` is the camera's, world; `degree` is evaluated, at most that of `sh`.
void color(const Harmonics& sh, int degree, glm::vec3 view_position, const Block& block,
           std::size_t index, const Survivors& survivors, Colors& colors);

}  // namespace qs::cpu::fast
