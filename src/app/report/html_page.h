// SPDX-License-Identifier: MIT
//
// A web page in one file: pictures lie inside as data, nothing is fetched.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "raster/scene/image.h"

namespace qs {

/// Text as HTML shows it.
std::string html_escaped(const std::string& text);

class HtmlPage {
 public:
  explicit HtmlPage(std::string title) : title_(std::move(title)) {}

  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /// The first row is the head. Columns of words are left, those of numbers right; no cell is
  /// empty.
  void table(const std::vector<std::vector<std::string>>& rows);
  /// A picture with a sentence below it. `half`: two fit side by side, one call after the other.
  void picture(const Image& image, const std::string& caption, bool half = false);
  /// The same with a PNG file's bytes.
  void picture_file(const std::filesystem::path& png, const std::string& caption,
                    bool half = false);

  std::string text() const;

 private:
  void figure(const std::string& png_bytes, const std::string& caption, bool half);

  std::string title_, body_;
};

}  // namespace qs
