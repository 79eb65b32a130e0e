// SPDX-License-Identifier: MIT
#include "app/picture/canvas.h"

#include <algorithm>
#include <cassert>

namespace qs {

void fill_rect(Image& image, PixelRect rect, glm::vec3 color) {
  assert(image.channels == 3);
  const int x_end = std::min(rect.x + rect.width, image.width);
  const int y_end = std::min(rect.y + rect.height, image.height);
  for (int y = std::max(rect.y, 0); y < y_end; ++y) {
    for (int x = std::max(rect.x, 0); x < x_end; ++x) {
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = color[c];
    }
  }
}

void paste(Image& image, const Image& part, glm::ivec2 at) {
  assert(image.channels == 3 && part.channels == 3);
  const int x_end = std::min(at.x + part.width, image.width);
  const int y_end = std::min(at.y + part.height, image.height);
  for (int y = std::max(at.y, 0); y < y_end; ++y) {
    for (int x = std::max(at.x, 0); x < x_end; ++x) {
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = part.at(x - at.x, y - at.y, c);
    }
  }
}

Image cropped(const Image& image, PixelRect part) {
  Image result(part.width, part.height, 3);
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      for (int c = 0; c < 3; ++c)
        result.at(x, y, c) = std::clamp(image.at(part.x + x, part.y + y, c), 0.0f, 1.0f);
    }
  }
  return result;
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
