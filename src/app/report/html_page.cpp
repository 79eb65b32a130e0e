// SPDX-License-Identifier: MIT
#include "app/report/html_page.h"

#include <cctype>

#include <fmt/format.h>

#include "app/picture/palette.h"
#include "base/text.h"
#include "io/bytes/base64.h"
#include "io/bytes/json_text.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

constexpr std::size_t kMaxPictureBytes = std::size_t{64} << 20;

constexpr const char* kStyle = R"(
body { font: 17px/1.55 system-ui, sans-serif; color: var(--ink); background: #fff; margin: 0 auto;
  max-width: 1080px; padding: 2.5em 1.5em 5em; }
h1 { font-size: 2em; line-height: 1.2; margin: 0 0 .3em; }
h2 { font-size: 1.4em; margin: 2.2em 0 .4em; border-top: 1px solid var(--line); padding-top: 1em; }
p { max-width: 46em; }
table { border-collapse: collapse; margin: 1em 0; font-variant-numeric: tabular-nums; }
th, td { padding: .3em .9em; text-align: right; border-bottom: 1px solid var(--line); }
.words { text-align: left; }
td:first-child { white-space: nowrap; }
th { border-bottom: 2px solid var(--ink); font-weight: 600; }
figure { margin: 1.2em 0; }
figure.half { display: inline-block; width: 49%; margin: .6em 0; vertical-align: top; }
figure img { width: 100%; display: block; }
figcaption { color: var(--faint); font-size: .92em; padding: .35em .3em 0; }
@media (max-width: 760px) { figure.half { width: 100%; } }
)";

}  // namespace

void HtmlPage::heading(const std::string& text) {
  body_ += fmt::format("<h2>{}</h2>\n", html_escaped(text));
}

void HtmlPage::paragraph(const std::string& text) {
  body_ += fmt::format("<p>{}</p>\n", html_escaped(text));
}

void HtmlPage::table(const std::vector<std::vector<std::string>>& rows) {
  // The first cell below the head decides whether a column holds words or numbers.
  const auto has_words = [&](std::size_t column) {
    if (column == 0 || rows.size() < 2) return column == 0;
    return !rows[1].at(column).empty() &&
           std::isalpha(static_cast<unsigned char>(rows[1][column].front())) != 0;
  };
  body_ += "<table>\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    body_ += "<tr>";
    for (std::size_t column = 0; column < rows[i].size(); ++column)
      body_ +=
          fmt::format("<{0}{1}>{2}</{0}>", i == 0 ? "th" : "td",
                      has_words(column) ? " class=\"words\"" : "", html_escaped(rows[i][column]));
    body_ += "</tr>\n";
  }
  body_ += "</table>\n";
}

void HtmlPage::picture(const Image& image, const std::string& caption, bool half) {
  figure("png", encode_png(image), caption, half);
}

void HtmlPage::drawing(const std::filesystem::path& svg, const std::string& caption, bool half) {
  figure("svg+xml", read_text_file(svg, kMaxPictureBytes), caption, half);
}

void HtmlPage::figure(const char* type, const std::string& bytes, const std::string& caption,
                      bool half) {
  body_ += fmt::format(
      "<figure{}><img alt=\"{}\" src=\"data:image/{};base64,{}\"><figcaption>{}</figcaption>"
      "</figure>\n",
      half ? " class=\"half\"" : "", html_escaped(caption), type, base64(bytes),
      html_escaped(caption));
}

std::string HtmlPage::text() const {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"generator\" content=\"quadsplat\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{0}</title>\n<style>\n:root {{ color-scheme: light; --ink: {1}; --faint: {2}; "
      "--line: {3}; }}{4}</style>\n</head>\n<body>\n<h1>{0}</h1>\n{5}</body>\n</html>\n",
      html_escaped(title_), hex_text(on_white::kInk), hex_text(on_white::kFaint),
      hex_text(on_white::kLine), kStyle, body_);
}

}  // namespace qs
