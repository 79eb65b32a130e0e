// SPDX-License-Identifier: MIT
//
// sh_color() of kernel/sh.h for the survivors of a block.
#pragma once

#include "raster/cpu/fast/survivors.h"

namespace qs::cpu::fast {

/// Per Gaussian of a block.
struct alignas(64) Colors {
  float red[kBlock], green[kBlock], blue[kBlock];
};

/// The inputs of a frame's colours, besides the Gaussians' positions.
struct ColorInput {
  const Harmonics& sh;
  int degree;               ///< evaluated, at most sh.degree
  glm::vec3 view_position;  ///< the camera, world
};

/// Fills the colours of the survivors of block `index`, and of other members of their groups.
void color(const ColorInput& in, const Block& block, std::size_t index, const Survivors& survivors,
           Colors& colors);

}  // namespace qs::cpu::fast
