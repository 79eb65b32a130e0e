// SPDX-License-Identifier: MIT
#include "app/picture/font.h"

#include <algorithm>
#include <cmath>

#include <imgui.h>

#include "base/assets.h"

namespace qs {
namespace {

// Removes the first code point from `text` and returns it, or '?' if it has three or four bytes.
ImWchar take_character(std::string_view& text) {
  const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  std::size_t length = byte(0) < 0x80 ? 1 : byte(0) < 0xe0 ? 2 : byte(0) < 0xf0 ? 3 : 4;
  length = std::min(length, text.size());
  ImWchar character = '?';
  if (byte(0) < 0x80) character = byte(0);
  if (length == 2) character = static_cast<ImWchar>((byte(0) & 0x1f) << 6 | (byte(1) & 0x3f));
  text.remove_prefix(length);
  return character;
}

}  // namespace

Font::Font(int line_height)
    : line_height_(std::max(line_height, 8)), atlas_(std::make_unique<ImFontAtlas>()) {
  ImFontConfig config;
  config.OversampleH = 1;  // glyphs are placed on whole pixels and copied texel by texel
  config.PixelSnapH = true;
  const auto size = static_cast<float>(line_height_);
  if (const auto file = find_font()) {
    font_ = atlas_->AddFontFromFileTTF(file->c_str(), size, &config);
  }
  if (!font_) {
    config.SizePixels = size;
    font_ = atlas_->AddFontDefault(&config);
  }
  unsigned char* texels = nullptr;
  atlas_->GetTexDataAsAlpha8(&texels, &texture_width_, &texture_height_);
  texels_ = texels;
}

Font::~Font() = default;

template <class Visit>
void Font::for_each_glyph(std::string_view text, Visit&& visit) const {
  float pen = 0;
  while (!text.empty()) {
    const ImFontGlyph& glyph = *font_->FindGlyph(take_character(text));
    visit(glyph, pen);
    pen += glyph.AdvanceX;
  }
}

int Font::width(std::string_view text) const {
  float right = 0;
  for_each_glyph(text,
                 [&right](const ImFontGlyph& glyph, float pen) { right = pen + glyph.AdvanceX; });
  return static_cast<int>(std::ceil(right));
}

void Font::for_each_covered_pixel(
    std::string_view text, const std::function<void(int x, int y, float coverage)>& visit) const {
  for_each_glyph(text, [&](const ImFontGlyph& glyph, float pen) {
    const int left = static_cast<int>(std::lround(pen + glyph.X0)),
              top = static_cast<int>(std::lround(glyph.Y0));
    const int u = static_cast<int>(std::lround(glyph.U0 * static_cast<float>(texture_width_)));
    const int v = static_cast<int>(std::lround(glyph.V0 * static_cast<float>(texture_height_)));
    const int u_end = static_cast<int>(std::lround(glyph.U1 * static_cast<float>(texture_width_)));
    const int v_end = static_cast<int>(std::lround(glyph.V1 * static_cast<float>(texture_height_)));
    for (int y = v; y < v_end; ++y) {
      for (int x = u; x < u_end; ++x) {
        const unsigned char texel = texels_[y * texture_width_ + x];
        if (texel != 0) visit(left + x - u, top + y - v, static_cast<float>(texel) / 255);
      }
    }
  });
}

}  // namespace qs
