// SPDX-License-Identifier: MIT
// Compiled alone: clang optimises sanitized JSON for minutes in a larger unit.
#include "io/bytes/json_text.h"

#include <algorithm>
#include <fstream>
#include <system_error>

#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "io/bytes/file_guard.h"

namespace qs {
namespace {

constexpr int kMaxDepth = 64;

struct Shape {
  int depth = 0;           // deepest nesting of brackets
  std::size_t values = 0;  // an upper bound: commas and opening brackets
};

Shape shape_of(std::string_view text) {
  Shape shape;
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == ',') {
      ++shape.values;
    } else if (c == '[' || c == '{') {
      shape.depth = std::max(shape.depth, ++depth);
      ++shape.values;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return shape;
}

}  // namespace

nlohmann::json parse_json(std::string_view text, std::string_view source, std::size_t max_values) {
  const Shape shape = shape_of(text);
  if (shape.depth > kMaxDepth) {
    fail("{}: not valid JSON: more than {} levels of brackets", source, kMaxDepth);
  }
  if (shape.values > max_values) fail("{}: JSON of more than {} values", source, max_values);
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    const std::size_t at = std::min<std::size_t>(error.byte == 0 ? 0 : error.byte - 1, text.size());
    const auto line =
        1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    fail("{}: not valid JSON: error in line {}, at byte {}", source, line, at);
  } catch (const nlohmann::json::out_of_range&) {
    fail("{}: not valid JSON: a number is out of range", source);
  }
}

nlohmann::ordered_json parse_own_json(std::string_view text) {
  return nlohmann::ordered_json::parse(text);
}

std::string json_file_text(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string json_line(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string read_text_file(const std::filesystem::path& path, std::size_t max_bytes) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);
  if (error == std::errc::no_such_file_or_directory)
    fail("{}: cannot be read: no such file", path.string());
  if (std::filesystem::is_directory(path))
    fail("{}: is a folder, but a file is needed", path.string());
  if (error) fail("{}: cannot be read: {}", path.string(), error.message());
  if (bytes > max_bytes)
    fail("{}: {} bytes are more than the {} that are read", path.string(), bytes, max_bytes);
  std::ifstream file(path, std::ios::binary);
  if (!file) fail("{}: cannot be opened", path.string());
  note_input(path);
  std::string text(bytes + 1, '\0');
  std::size_t size = 0;
  // A file of /proc or a pipe has more bytes than its size says.
  while (file.read(text.data() + size, static_cast<std::streamsize>(text.size() - size)) ||
         file.gcount() > 0) {
    size += static_cast<std::size_t>(file.gcount());
    if (size > max_bytes)
      fail("{}: more than the {} bytes that are read", path.string(), max_bytes);
    if (size == text.size()) text.resize(2 * text.size());
  }
  text.resize(size);
  return text;
}

}  // namespace qs
