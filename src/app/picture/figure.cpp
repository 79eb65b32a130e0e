// SPDX-License-Identifier: MIT
#include "app/picture/figure.h"

#include <fmt/format.h>

#include "base/text.h"
#include "io/bytes/base64.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

constexpr const char* kAnchors[] = {"start", "middle", "end"};  // index = Align

std::string svg_of(const FigurePicture& picture) {
  return fmt::format(
      "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" href=\"data:image/png;base64,{}\"/>\n",
      picture.at.x, picture.at.y, picture.image.width, picture.image.height,
      base64(encode_png(picture.image)));
}

std::string svg_of(const FigureLine& line) {
  std::string points;
  for (const glm::vec2 at : line.points) points += fmt::format("{:.1f},{:.1f} ", at.x, at.y);
  return fmt::format(
      "<{} points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-opacity=\"{}\" "
      "stroke-linecap=\"round\" stroke-linejoin=\"round\"/>\n",
      line.closed ? "polygon" : "polyline", points, hex_text(line.pen.color), line.pen.width,
      line.pen.opacity);
}

// The baseline of Roboto is 0.78 of a line below its top, and a line is 1.17 times the font's size.
std::string svg_of(const FigureText& text) {
  const double size = text.size;
  return fmt::format(
      "<text x=\"{}\" y=\"{:.1f}\" font-size=\"{:.1f}\" fill=\"{}\" text-anchor=\"{}\">{}</text>\n",
      text.at.x, text.at.y + 0.78 * size, size / 1.17, hex_text(text.color),
      kAnchors[static_cast<int>(text.align)], html_escaped(text.text));
}

}  // namespace

Image draw_figure(const Figure& figure) {
  Image page = plain_picture(figure.size.x, figure.size.y, on_white::kWhite);
  for (const FigurePicture& picture : figure.pictures) paste(page, picture.image, picture.at);
  for (const FigureLine& line : figure.lines) stroke(page, line.points, line.closed, line.pen);
  for (const FigureText& text : figure.texts)
    draw_text(page, Font(text.size), text.at, text.text, text.color, text.align);
  return page;
}

std::string figure_svg(const Figure& figure, const std::string& title) {
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} "
      "{1}\" font-family=\"Roboto, Helvetica, Arial, sans-serif\">\n<title>{2}</title>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
      figure.size.x, figure.size.y, html_escaped(title));
  for (const FigurePicture& picture : figure.pictures) svg += svg_of(picture);
  for (const FigureLine& line : figure.lines) svg += svg_of(line);
  for (const FigureText& text : figure.texts) svg += svg_of(text);
  return svg + "</svg>\n";
}

}  // namespace qs
