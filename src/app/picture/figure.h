// SPDX-License-Identifier: MIT
//
// A figure of pictures, lines and texts on white. It becomes one PNG, or an SVG whose texts
// stay texts.
#pragma once

#include <string>
#include <vector>

#include "app/picture/canvas.h"
#include "app/picture/palette.h"

namespace qs {

struct FigureText {
  glm::ivec2 at{0};  ///< top left, top centre or top right of the line
  int size = 20;     ///< height of the line, pixels
  std::string text;
  glm::vec3 color = on_white::kInk;
  Align align = Align::left;
};

struct FigurePicture {
  glm::ivec2 at{0};  ///< top left
  Image image;       ///< RGB
};

struct FigureLine {
  std::vector<glm::vec2> points;  ///< a dot is the same point twice
  Pen pen;
  bool closed = false;
};

struct Figure {
  glm::ivec2 size{0};  ///< pixels
  std::vector<FigurePicture> pictures;
  std::vector<FigureLine> lines;
  std::vector<FigureText> texts;
};

Image draw_figure(const Figure& figure);

/// The pictures are embedded as PNG files. `title`: for readers of the file that cannot see it.
std::string figure_svg(const Figure& figure, const std::string& title);

}  // namespace qs
