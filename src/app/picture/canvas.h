// SPDX-License-Identifier: MIT
//
// Draws filled rectangles, pictures, text, antialiased lines and polygons on an RGB picture.
// Everything is clipped to the picture. Colours are 0..1. Coordinates are pixels from the top left;
// the points of lines and polygons are continuous: pixel i covers [i, i + 1].
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string_view>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/not_copied.h"
#include "raster/scene/image.h"

struct ImFontAtlas;
struct ImFont;

namespace qs {

/// A font of one size for drawing on pictures without a window: Roboto from the assets, rasterised
/// by Dear ImGui's font atlas as in the viewer. If the asset is missing, ImGui's built-in pixel
/// font is used. Covers ASCII and Latin-1.
class Font : NotCopied {
 public:
  /// `line_height` in pixels; at least 8 is used.
  explicit Font(int line_height);
  ~Font();

  int line_height() const { return line_height_; }

  /// Width of one line of UTF-8 text in pixels.
  int width(std::string_view text) const;

  /// Draws one line of text with its top left at `at`.
  void draw(Image& image, glm::ivec2 at, std::string_view text, glm::vec3 color) const;

 private:
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
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) result.at(x, y, c) = value(x, y, c);
  return result;
}

/// A picture of one colour.
Image plain_picture(int width, int height, glm::vec3 color);

void fill_rect(Image& image, PixelRect rect, glm::vec3 color);

/// Copies `part` onto `image`, with its top left corner at `at`.
void paste(Image& image, const Image& part, glm::ivec2 at);

/// A copy of a part, which must be inside the image; values are clamped to 0..1.
Image cropped(const Image& image, PixelRect part);

/// Draws one line of text. `at` is the top left, top centre or top right of the line. Returns the
/// width of the line in pixels.
int draw_text(Image& image, const Font& font, glm::ivec2 at, std::string_view text, glm::vec3 color,
              Align align = Align::left);

/// The corners of a rectangle in their order around it.
inline std::array<glm::vec2, 4> corners_of(glm::vec2 low, glm::vec2 high) {
  return {low, glm::vec2(high.x, low.y), high, glm::vec2(low.x, high.y)};
}

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
