// SPDX-License-Identifier: MIT
#include "app/picture/canvas.h"

#include <algorithm>
#include <cassert>

namespace qs {

void fill_rect(Image& image, PixelRect rect, glm::vec3 color) {
  assert(image.channels == 3);
  for_each_value(image, rect, [&](int x, int y, int c) { image.at(x, y, c) = color[c]; });
}

void paste(Image& image, const Image& part, glm::ivec2 at) {
  assert(image.channels == 3 && part.channels == 3);
  for_each_value(image, {at.x, at.y, part.width, part.height},
                 [&](int x, int y, int c) { image.at(x, y, c) = part.at(x - at.x, y - at.y, c); });
}

Image cropped(const Image& image, PixelRect part) {
  return picture_of(part.width, part.height, [&](int x, int y, int c) {
    return std::clamp(image.at(part.x + x, part.y + y, c), 0.0f, 1.0f);
  });
}

int draw_text(Image& image, const Font& font, glm::ivec2 at, std::string_view text, glm::vec3 color,
              Align align) {
  assert(image.channels == 3);
  const int width = font.width(text);
  if (align == Align::center) at.x -= width / 2;
  if (align == Align::right) at.x -= width;
  font.for_each_covered_pixel(text, [&](int dx, int dy, float coverage) {
    const int x = at.x + dx, y = at.y + dy;
    if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
    for (int c = 0; c < 3; ++c) {
      float& value = image.at(x, y, c);
      value += coverage * (color[c] - value);
    }
  });
  return width;
}

}  // namespace qs
