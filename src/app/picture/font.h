// SPDX-License-Identifier: MIT
//
// A font of one size for drawing on pictures without a window: Roboto from the assets, rasterised
// by Dear ImGui's font atlas as in the viewer. If the asset is missing, ImGui's built-in pixel font
// is used. Covers ASCII and Latin-1.
#pragma once

#include <functional>
#include <memory>
#include <string_view>

struct ImFontAtlas;
struct ImFont;

namespace qs {

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

}  // namespace qs
