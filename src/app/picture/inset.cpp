// SPDX-License-Identifier: MIT
#include "app/picture/inset.h"

#include <algorithm>
#include <cmath>

namespace qs {
namespace {

constexpr glm::vec3 kFrame{0.9f, 0.1f, 0.1f};

// Draws on the picture around the outside of `rect`.
void draw_frame(Image& image, PixelRect rect) {
  const int width = std::max(1, std::min(image.width, image.height) / 250);
  const PixelRect outer{rect.x - width, rect.y - width, rect.width + 2 * width,
                        rect.height + 2 * width};
  fill_rect(image, {outer.x, outer.y, outer.width, width}, kFrame);
  fill_rect(image, {outer.x, rect.y + rect.height, outer.width, width}, kFrame);
  fill_rect(image, {outer.x, outer.y, width, outer.height}, kFrame);
  fill_rect(image, {rect.x + rect.width, outer.y, width, outer.height}, kFrame);
}

}  // namespace

glm::ivec2 enlarged_size(PixelRect part, double zoom) {
  return {static_cast<int>(std::lround(part.width * zoom)),
          static_cast<int>(std::lround(part.height * zoom))};
}

Image enlarged(const Image& image, PixelRect part, double zoom) {
  const Image source = cropped(image, part);
  const glm::ivec2 size = enlarged_size(part, zoom);
  Image result(size.x, size.y, 3);
  // The two pixels around a pixel's centre, and the weight of the second.
  struct Between {
    int first, second;
    float weight;
  };
  const auto between = [zoom](int pixel, int count) {
    const double center =
        std::clamp((pixel + 0.5) / zoom - 0.5, 0.0, static_cast<double>(count - 1));
    const int first = static_cast<int>(center);
    return Between{first, std::min(first + 1, count - 1), static_cast<float>(center - first)};
  };
  for (int y = 0; y < size.y; ++y) {
    const Between row = between(y, source.height);
    for (int x = 0; x < size.x; ++x) {
      const Between column = between(x, source.width);
      for (int c = 0; c < 3; ++c) {
        const auto of_row = [&](int from) {
          return source.at(column.first, from, c) * (1 - column.weight) +
                 source.at(column.second, from, c) * column.weight;
        };
        result.at(x, y, c) = of_row(row.first) * (1 - row.weight) + of_row(row.second) * row.weight;
      }
    }
  }
  return result;
}

Image with_inset(const Image& image, PixelRect part, double zoom) {
  const Image inset = enlarged(image, part, zoom);
  Image result = cropped(image, {0, 0, image.width, image.height});
  draw_frame(result, part);
  const bool left = 2 * part.x + part.width > image.width;
  const bool top = 2 * part.y + part.height > image.height;
  const glm::ivec2 at{left ? 0 : image.width - inset.width, top ? 0 : image.height - inset.height};
  draw_frame(result, {at.x, at.y, inset.width, inset.height});
  paste(result, inset, at);
  return result;
}

}  // namespace qs
