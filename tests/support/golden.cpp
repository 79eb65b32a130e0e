// SPDX-License-Identifier: MIT
#include "support/golden.h"

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

#include <gtest/gtest.h>

#include "io/picture/image_file.h"
#include "support/shared.h"

namespace qs::test {
namespace {

bool updating() { return std::getenv("QUADSPLAT_UPDATE_GOLDEN") != nullptr; }

std::filesystem::path golden_path(const std::string& name) {
  const char* const folder = std::getenv("QUADSPLAT_GOLDEN_FOLDER");
  return folder != nullptr ? folder / std::filesystem::path(name)
                           : source_path("tests/golden/" + name);
}

/// The path to which the result is written: the golden file, or a temporary file for comparison.
std::filesystem::path output_path(const std::string& name) {
  const std::filesystem::path path =
      updating() ? golden_path(name)
                 : std::filesystem::temp_directory_path() / "quadsplat-golden" / name;
  std::filesystem::create_directories(path.parent_path());
  return path;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The number that starts at `at`, without a sign; "" if there is none.
std::string number_at(const std::string& line, std::size_t at) {
  std::size_t end = at;
  while (end < line.size() && std::isdigit(static_cast<unsigned char>(line[end]))) ++end;
  if (end > at && end + 1 < line.size() && line[end] == '.' &&
      std::isdigit(static_cast<unsigned char>(line[end + 1]))) {
    for (++end; end < line.size() && std::isdigit(static_cast<unsigned char>(line[end]));) ++end;
    if (end + 2 < line.size() && line[end] == 'e' && line[end + 1] == '-') {
      for (end += 2; end < line.size() && std::isdigit(static_cast<unsigned char>(line[end]));)
        ++end;
    }
  }
  return line.substr(at, end - at);
}

bool numbers_agree(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const std::size_t point = a.find('.');
  if (point == a.npos || b.find('.') == b.npos) return false;
  const double x = std::stod(a), y = std::stod(b);
  const double last_digit = std::pow(10.0, -static_cast<double>(a.size() - point - 1));
  const bool same_digits = a.size() - point == b.size() - b.find('.');
  return std::abs(x - y) <= 1e-5 * std::abs(x) ||
         (same_digits && std::abs(x - y) < 1.5 * last_digit);
}

bool lines_agree(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    const std::string x = number_at(a, i), y = number_at(b, j);
    if (!x.empty() && !y.empty()) {
      if (!numbers_agree(x, y)) return false;
      i += x.size();
      j += y.size();
    } else if (a[i++] != b[j++]) {
      return false;
    }
  }
  return i == a.size() && j == b.size();
}

}  // namespace

void expect_golden_image(const std::string& name, const Image& image) {
  if (updating()) return write_image(image, output_path(name));
  ASSERT_TRUE(std::filesystem::exists(golden_path(name))) << name << " is missing";
  const Image golden = read_image(golden_path(name));
  std::size_t different = 0;
  const bool same_size = golden.width == image.width && golden.height == image.height;
  for (int y = 0; same_size && y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      int largest = 0;
      for (int c = 0; c < 3; ++c)
        largest =
            std::max(largest, std::abs(to_8bit(golden.at(x, y, c)) - to_8bit(image.at(x, y, c))));
      different += largest > 2;
    }
  }
  const auto pixels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (same_size && different <= pixels / 10000) return;
  const std::filesystem::path path = output_path(name);
  write_image(image, path);
  ADD_FAILURE() << "tests/golden/" << name << ": " << golden.width << " x " << golden.height
                << ", now " << image.width << " x " << image.height << "; " << different
                << " pixels differ; the new picture is " << path.string();
}

void expect_golden_text(const std::string& name, const std::string& text) {
  if (updating()) {
    std::ofstream(output_path(name), std::ios::binary) << text;
    return;
  }
  ASSERT_TRUE(std::filesystem::exists(golden_path(name))) << name << " is missing";
  const std::vector<std::string> golden = lines_of(content_of(golden_path(name))),
                                 lines = lines_of(text);
  std::size_t line = 0;
  while (line < golden.size() && line < lines.size() && lines_agree(golden[line], lines[line]))
    ++line;
  if (line == golden.size() && line == lines.size()) return;
  const std::filesystem::path path = output_path(name);
  std::ofstream(path, std::ios::binary) << text;
  ADD_FAILURE() << "tests/golden/" << name << ":" << line + 1 << ": "
                << (line < golden.size() ? golden[line] : "(ends)") << "\n  now "
                << (line < lines.size() ? lines[line] : "(ends)") << "\n  the new text is "
                << path.string();
}

}  // namespace qs::test
