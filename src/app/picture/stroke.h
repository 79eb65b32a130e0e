// SPDX-License-Identifier: MIT
//
// Draws antialiased lines and polygons on an RGB picture, clipped to it. Coordinates are continuous
// and start at the picture's top left corner: pixel i covers [i, i + 1].
#pragma once

#include <span>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/scene/image.h"

namespace qs {

struct Pen {
  glm::vec3 color{0.0f};
  float width = 1;    ///< pixels
  float opacity = 1;  ///< 0..1, applied once, also where the line crosses itself
  float dash = 0;     ///< length of a dash and of a gap in pixels; 0 = no gaps
};

/// Draws the line through the points, with round ends.
void stroke(Image& image, std::span<const glm::vec2> points, bool closed, const Pen& pen);

/// Fills a polygon by the even-odd rule.
void fill_polygon(Image& image, std::span<const glm::vec2> points, glm::vec3 color, float opacity);

}  // namespace qs
