// SPDX-License-Identifier: MIT
//
// Draws filled rectangles, pictures and text on an RGB picture; stroke.h draws lines. Everything is
// clipped to the picture. Coordinates are pixels from the top left; colours are 0..1.
#pragma once

#include <string_view>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "app/picture/font.h"
#include "raster/scene/image.h"

namespace qs {

struct PixelRect {
  int x = 0, y = 0, width = 0, height = 0;
};

enum class Align { left, center, right };

void fill_rect(Image& image, PixelRect rect, glm::vec3 color);

/// Copies `part` onto `image`, with its top left corner at `at`.
void paste(Image& image, const Image& part, glm::ivec2 at);

/// A copy of a part, which must be inside the image; values are clamped to 0..1.
Image cropped(const Image& image, PixelRect part);

/// Draws one line of text. `at` is the top left, top centre or top right of the line. Returns the
/// width of the line in pixels.
int draw_text(Image& image, const Font& font, glm::ivec2 at, std::string_view text, glm::vec3 color,
              Align align = Align::left);

}  // namespace qs
