// SPDX-License-Identifier: MIT
//
// Colour maps for heat maps. They are safe for colour-blind readers, and their lightness is
// monotonic, so that they can be printed in gray.
#pragma once

#include <glm/vec3.hpp>

namespace qs {

/// From dark violet over blue and green to yellow. `t` is clamped to 0..1.
glm::vec3 viridis(float t);

/// For signed values: blue, almost white at 0, orange to brown. `t` is clamped to -1..1.
glm::vec3 diverging(float t);

}  // namespace qs
