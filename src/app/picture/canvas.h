// SPDX-License-Identifier: MIT
//
// Drawing on an RGB picture: filled rectangles, pictures and text; lines are in stroke.h.
// Everything is clipped to the picture. Coordinates are pixels from the top left; colours are as
// stored in the picture, 0..1.
#pragma once

#include <string_view>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "app/picture/font.h"
#include "raster/scene/image.h"

namespace qs {

struct Rect {
  int x = 0, y = 0, width = 0, height = 0;
};

enum class Align { left, center, right };

void fill_rect(Image& image, Rect rect, glm::vec3 color);

/// Copies a picture onto another one, its top left corner to `at`.
void paste(Image& image, const Image& part, glm::ivec2 at);

/// Draws one line of text; `at` is the top of the line and its left, middle or right. Returns its
/// width.
int draw_text(Image& image, const Font& font, glm::ivec2 at, std::string_view text, glm::vec3 color,
              Align align = Align::left);

}  // namespace qs
