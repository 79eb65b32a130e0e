// SPDX-License-Identifier: MIT
//
// A web page in one file: pictures are embedded, so that the page loads nothing else.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "raster/scene/image.h"

namespace qs {

class HtmlPage {
 public:
  explicit HtmlPage(std::string title) : title_(std::move(title)) {}

  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /// The first row is the head. Columns of words are aligned left, columns of numbers right.
  void table(const std::vector<std::vector<std::string>>& rows);
  /// A picture with a caption below it. `half`: two consecutive pictures fit side by side.
  void picture(const Image& image, const std::string& caption, bool half = false);
  /// An SVG file with a caption, as picture().
  void drawing(const std::filesystem::path& svg, const std::string& caption, bool half = false);

  std::string text() const;

 private:
  void figure(const char* type, const std::string& bytes, const std::string& caption, bool half);

  std::string title_, body_;
};

}  // namespace qs
