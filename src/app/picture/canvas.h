// SPDX-License-Identifier: MIT
//
// Draws filled rectangles, pictures, text, antialiased lines and polygons on an RGB picture.
// Everything is clipped to the picture. Colours are 0..1. Coordinates are pixels from the top left;
// those of lines and polygons are continuous: pixel i covers [i, i + 1].
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/scene/image.h"

struct ImFontAtlas;
struct ImFont;

namespace qs {

/// A font of one size for drawing on pictures without a window: Roboto from the assets, rasterised
/// by Dear ImGui's font atlas as in the viewer. If the asset is missing, ImGui's built-in pixel
/// font is used. Covers ASCII and Latin-1.
class Font {
 public:
  /// `line_height` in pixels; at least 8 is used.
  explicit Font(int line_height);
  ~Font();
  Font(const Font&) = delete;
  Font& operator=(const Font&) = delete;

  int line_height() const { return line_height_; }

  /// Width of one line of UTF-8 text in pixels.
  int width(std::string_view text) const;

  /// Calls visit(x, y, coverage) for every pixel that the text covers. Coordinates are relative to
  /// the top left of the line; coverage is in (0, 1].
  void for_each_covered_pixel(std::string_view text,
                              const std::function<void(int x, int y, float coverage)>& visit) const;

 private:
  template <class Visit>
  void for_each_glyph(std::string_view text, Visit&& visit) const;

  int line_height_;
  std::unique_ptr<ImFontAtlas> atlas_;
  ImFont* font_ = nullptr;                 // owned by the atlas
  const unsigned char* texels_ = nullptr;  // owned by the atlas
  int texture_width_ = 0, texture_height_ = 0;
};

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

/// Size of the enlarged part, pixels.
glm::ivec2 enlarged_size(PixelRect part, double zoom);

/// A part of an RGB picture, `zoom` >= 1 times as large, interpolated linearly between pixels.
/// `part` is inside the picture. Values are clamped to 0..1.
Image enlarged(const Image& image, PixelRect part, double zoom);

/// The picture with a frame around `part` and the enlarged part in the corner farthest from it.
/// The enlarged part is not larger than the picture.
Image with_inset(const Image& image, PixelRect part, double zoom);

}  // namespace qs
