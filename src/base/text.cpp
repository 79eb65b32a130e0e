// SPDX-License-Identifier: MIT
#include "base/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

#include <glm/geometric.hpp>

#include "base/fail.h"

namespace qs {
namespace {

template <class T>
bool parse_all(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && !text.empty();
}

// Numbers with a separator between them, as many as the vector has.
template <class Vector>
bool parse_vector(std::string_view text, char separator, Vector& vector) {
  const std::vector<std::string> words = separated(text, separator);
  bool good = words.size() == static_cast<std::size_t>(Vector::length());
  for (int i = 0; good && i < Vector::length(); ++i)
    good = parse_all(std::string_view(words[static_cast<std::size_t>(i)]), vector[i]);
  return good;
}

}  // namespace

int parse_integer(std::string_view what, std::string_view text, int low, int high) {
  int value = 0;
  if (!parse_all(text, value) || value < low || value > high)
    fail(ErrorKind::usage, "{}: '{}' is not a whole number from {} to {}", what, text, low, high);
  return value;
}

double parse_real(std::string_view what, std::string_view text, double low, double high) {
  double value = 0;
  if (!parse_all(text, value) || !(value >= low && value <= high))
    fail(ErrorKind::usage, "{}: '{}' is not a number from {} to {}", what, text, low, high);
  return value;
}

std::uint64_t parse_bytes(std::string_view what, std::string_view text) {
  constexpr std::string_view kUnits = "KMGT";
  const std::size_t end = std::min(text.find_first_of(kUnits), text.size());
  const std::string_view unit = text.substr(end);  // "MiB" of "16MiB"
  const bool known = unit.size() < 2 || unit.substr(1) == "B" || unit.substr(1) == "iB";
  const double base = unit.ends_with("iB") ? 1024 : 1000;
  const double factor =
      unit.empty() ? 1 : std::pow(base, static_cast<double>(kUnits.find(unit[0])) + 1);
  double value = 0;
  if (!known || !parse_all(text.substr(0, end), value) ||
      !(value * factor >= 1 && value * factor <= 1e18))
    fail(ErrorKind::usage, "{}: '{}' is not a number of bytes such as 800M or 1.5G", what, text);
  return static_cast<std::uint64_t>(std::llround(value * factor));
}

glm::ivec2 parse_size(std::string_view what, std::string_view text, std::string_view shape) {
  constexpr int kMaxSide = 32768;
  glm::ivec2 size{0};
  if (!parse_vector(text, 'x', size) || size.x < 1 || size.y < 1 ||
      std::max(size.x, size.y) > kMaxSide)
    fail(ErrorKind::usage, "{}: '{}' is not {} with sides from 1 to {}", what, text, shape,
         kMaxSide);
  return size;
}

glm::vec3 parse_color(std::string_view what, std::string_view text) {
  glm::vec3 color{0.0f};
  bool good = parse_vector(text, ',', color);
  for (int c = 0; c < 3; ++c) good = good && color[c] >= 0 && color[c] <= 1;
  if (!good) fail(ErrorKind::usage, "{}: '{}' is not R,G,B with values from 0 to 1", what, text);
  return color;
}

glm::dvec3 parse_direction(std::string_view what, std::string_view text) {
  constexpr std::string_view kAxisNames[] = {"x", "y", "z", "-x", "-y", "-z"};
  glm::dvec3 direction{0.0};
  for (int i = 0; i < 6; ++i)
    if (text == kAxisNames[i]) direction[i % 3] = i < 3 ? 1 : -1;
  if (direction != glm::dvec3(0)) return direction;
  const bool good = parse_vector(text, ',', direction);
  const double length = glm::length(direction);
  if (!good || !(length > 0) || !std::isfinite(length))
    fail(ErrorKind::usage, "{}: '{}' is neither x, -x, y, -y, z, -z nor a direction X,Y,Z", what,
         text);
  return direction / length;
}

void add_new(std::vector<std::string>& list, const std::string& word) {
  if (std::ranges::find(list, word) == list.end()) list.push_back(word);
}

std::string joined(std::span<const std::string> words, std::string_view separator) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += separator;
    text += word;
  }
  return text;
}

std::vector<std::string> separated(std::string_view text, char separator) {
  std::vector<std::string> words;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    words.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

std::string escaped(std::string_view text, std::initializer_list<Escape> escapes) {
  std::string result;
  for (const char c : text) {
    const auto escape = std::ranges::find(escapes, c, &Escape::first);
    result += escape == escapes.end() ? std::string_view(&c, 1) : escape->second;
  }
  return result;
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  return '"' + escaped(text, {{'"', "\"\""}}) + '"';
}

std::string markdown_text(const std::string& text) {
  return escaped(text, {{'|', "\\|"}, {'\\', "\\\\"}, {'<', "\\<"}, {'\n', " "}, {'\r', " "}});
}

std::string markdown_code(const std::string& text) {
  return '`' + escaped(text, {{'|', "\\|"}, {'`', "'"}, {'\n', " "}, {'\r', " "}}) + '`';
}

std::string shell_word(const std::string& word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+./,:=@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  return '\'' + escaped(word, {{'\'', R"('\'')"}}) + '\'';
}

std::string grouped(std::uint64_t number) {
  const std::string digits = fmt::format("{}", number);
  std::string result;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) result += ',';
    result += digits[i];
  }
  return result;
}

std::string counted(std::uint64_t number, std::string_view thing) {
  return fmt::format("{} {}{}", grouped(number), thing, number == 1 ? "" : "s");
}

std::string bytes_text(std::uint64_t bytes) {
  static constexpr std::array kUnits = {"bytes", "kB", "MB", "GB", "TB"};
  double value = static_cast<double>(bytes);
  std::size_t unit = 0;
  while (value >= 999.95 && unit + 1 < kUnits.size()) {
    value /= 1000;
    ++unit;
  }
  return unit == 0 ? fmt::format("{} bytes", bytes) : fmt::format("{:.1f} {}", value, kUnits[unit]);
}

std::string decibels(double psnr) { return std::isinf(psnr) ? "inf" : fmt::format("{:.2f}", psnr); }

std::string html_escaped(const std::string& text) {
  return escaped(text, {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}});
}

}  // namespace qs
