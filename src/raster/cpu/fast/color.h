// SPDX-License-Identifier: MIT
//
// kernel/sh.h's sh_color() for the Gaussians of a block that have tiles.
#pragma once

#include "raster/cpu/fast/survivors.h"

namespace qs::cpu::fast {

struct Harmonics {
  const float* values;  ///< of the cloud: RGB triples, per Gaussian all coefficients
  int stored_degree;    ///< of `values`
  int degree;           ///< evaluated, at most stored_degree
};

/// Fills red, green and blue of `survivors`. `view_position` is the camera's, world.
void color(const Harmonics& sh, glm::vec3 view_position, const glm::vec3* positions,
           Survivors& survivors);

}  // namespace qs::cpu::fast
