// SPDX-License-Identifier: MIT
//
// Smooth lines and areas on an RGB picture. Coordinates are continuous and count from the picture's
// top left corner, so that pixel i covers [i, i + 1]; whatever lies outside is clipped.
#pragma once

#include <span>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/scene/image.h"

namespace qs {

struct Pen {
  glm::vec3 color{0.0f};
  float width = 1;    ///< pixels
  float opacity = 1;  ///< 0..1, once for the whole line, also where it crosses itself
  float dash = 0;     ///< length of a dash and of the gap after it, pixels; 0 = no gaps
};

/// The line through the points, round at its ends.
void stroke(Image& image, std::span<const glm::vec2> points, bool closed, const Pen& pen);

/// The area inside a polygon, by the even-odd rule.
void fill_polygon(Image& image, std::span<const glm::vec2> points, glm::vec3 color, float opacity);

}  // namespace qs
