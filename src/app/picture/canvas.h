// SPDX-License-Identifier: MIT
//
// Draws filled rectangles, pictures and text on an RGB picture; stroke.h draws lines. Everything is
// clipped to the picture. Coordinates are pixels from the top left; colours are 0..1.
#pragma once

#include <algorithm>
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

/// The RGB picture with value(x, y, channel) at every place.
template <class Value>
Image picture_of(int width, int height, const Value& value) {
  Image result(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) result.at(x, y, c) = value(x, y, c);
    }
  }
  return result;
}

/// Calls set(x, y, channel) for every place of `rect` that is inside of the picture.
template <class Set>
void for_each_value(const Image& image, PixelRect rect, const Set& set) {
  const int x_end = std::min(rect.x + rect.width, image.width);
  const int y_end = std::min(rect.y + rect.height, image.height);
  for (int y = std::max(rect.y, 0); y < y_end; ++y) {
    for (int x = std::max(rect.x, 0); x < x_end; ++x) {
      for (int c = 0; c < 3; ++c) set(x, y, c);
    }
  }
}

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
