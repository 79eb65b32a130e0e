// SPDX-License-Identifier: MIT
#include "app/film/split_screen.h"

#include <algorithm>

#include "app/picture/canvas.h"
#include "app/picture/palette.h"

namespace qs {
namespace {

constexpr const char* kWidestLine = "00,000,000 pairs";
constexpr float kPlateOpacity = 0.7f;

// The plate of the labels has the same width in the whole film.
int plate_width(const Font& font, const std::vector<StripName>& names) {
  int widest = font.width(kWidestLine);
  for (const StripName& name : names) widest = std::max(widest, font.width(name.text));
  return widest + font.line_height();
}

// The height of letters: easy to read, but a label must fit into a strip.
int letter_height(const std::vector<StripName>& names, int width, int height) {
  constexpr int kLeast = 8;
  const int room = width / static_cast<int>(names.size());
  int letter = std::max(height / 22, kLeast);
  const int needed = plate_width(Font(letter), names);
  if (needed > room) letter = std::max(letter * room / needed + 1, kLeast);
  while (letter > kLeast && plate_width(Font(letter), names) > room)
    --letter;  // widths are rounded
  return letter;
}

}  // namespace

SplitScreen::SplitScreen(std::vector<StripName> names, int width, int height)
    : names_(std::move(names)),
      picture_(width, height, 3),
      font_(letter_height(names_, width, height)) {}

PixelRect SplitScreen::strip(std::size_t index) const {
  const auto edge = [&](std::size_t i) {
    return static_cast<int>(i * static_cast<std::size_t>(picture_.width) / names_.size());
  };
  return {edge(index), 0, edge(index + 1) - edge(index), picture_.height};
}

void SplitScreen::show(std::size_t index, const Image& view) {
  const PixelRect part = strip(index);
  for (int y = 0; y < part.height; ++y)
    std::copy_n(view.row(y) + 3 * part.x, 3 * part.width, picture_.row(y) + 3 * part.x);
}

void SplitScreen::label(std::size_t index, const std::vector<std::string>& lines) {
  const PixelRect part = strip(index);
  const int line = font_.line_height(), margin = line / 2;
  const int width = plate_width(font_, names_);
  if (width > part.width) return;
  const int height = static_cast<int>(lines.size() + 1) * line + margin;
  const int left = part.x + (part.width - width) / 2;
  int top = part.height - height - margin;
  fill_polygon(picture_, corners_of({left, top}, {left + width, top + height}), on_dark::kPanel,
               kPlateOpacity);
  top += margin / 2;
  const StripName& name = names_[index];
  const int middle = left + width / 2;
  draw_text(picture_, font_, {middle, top}, name.text, name.color, Align::center);
  for (const std::string& text : lines)
    draw_text(picture_, font_, {middle, top += line}, text, on_dark::kText, Align::center);
}

Image& SplitScreen::picture() {
  const int width = std::max(picture_.height / 360, 1);
  for (std::size_t i = 1; i < names_.size(); ++i)
    fill_rect(picture_, {strip(i).x - width / 2, 0, width, picture_.height}, on_dark::kText);
  return picture_;
}

}  // namespace qs
