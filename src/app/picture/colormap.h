// SPDX-License-Identifier: MIT
//
// Colour maps for heat maps. Colour-blind-safe, and of steadily rising lightness, so that they
// survive printing in gray.
#pragma once

#include <glm/vec3.hpp>

namespace qs {

/// `t` is clamped to 0..1: dark violet, blue, green, yellow.
glm::vec3 viridis(float t);

/// For signed values, `t` clamped to -1..1: blue, near white at 0, orange to brown.
glm::vec3 diverging(float t);

}  // namespace qs
