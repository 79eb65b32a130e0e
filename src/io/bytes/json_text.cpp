// SPDX-License-Identifier: MIT
// Compiled alone: clang optimises sanitized JSON for minutes in a larger unit.
#include "io/bytes/json_text.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <fstream>
#include <system_error>

#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/lfs_pointer.h"

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

// The text with quotes around every NaN and Infinity; empty if it has none.
std::string with_quoted_nan(std::string_view text) {
  std::string quoted;
  bool found = false, in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') in_string = !in_string;
    if (in_string && c == '\\' && i + 1 < text.size()) quoted += text[i++];
    const std::size_t end =
        in_string ? i : std::min(text.find_first_of(",:[]{}\" \t\r\n", i), text.size());
    const std::string_view word = text.substr(i, end - i);
    if (!is_not_finite(word)) {
      quoted += text[i];
      continue;
    }
    found = true;
    quoted.append("\"").append(word).append("\"");
    i = end - 1;
  }
  return found ? quoted : "";
}

// An object with both keys has the kind.
struct KindRow {
  JsonKind kind;
  std::string_view first, second;
};
constexpr std::array kObjectKinds = {
    KindRow{JsonKind::transforms, "frames", "frames"}, KindRow{JsonKind::sog, "means", "quats"},
    KindRow{JsonKind::streamed_sog, "filenames", "tree"},
    KindRow{JsonKind::gltf, "asset", "meshes"}, KindRow{JsonKind::instances, "scene", "instances"}};

constexpr std::string_view kJsonBlanks = " \t\r\n";

// Walks over the keys of one object. The bytes of nested values are only counted for brackets.
class KeyWalk {
 public:
  /// `begin`: the position after the object's opening bracket.
  KeyWalk(std::string_view text, std::size_t begin) : text_(text), at_(begin) {}

  /// Stores the next key. False at the end of the object or of the text.
  bool next(std::string_view& key) {
    for (int depth = 0; at_ < text_.size();) {
      const char c = text_[at_++];
      if (c == '"') {
        const std::size_t begin = at_;
        skip_string();
        if (depth == 0 && is_key()) {
          key = text_.substr(begin, at_ - begin - 1);
          return true;
        }
      } else if (c == '{' || c == '[') {
        ++depth;
      } else if ((c == '}' || c == ']') && --depth < 0) {
        break;
      }
    }
    return false;
  }

 private:
  // Moves behind the quote that ends the string.
  void skip_string() {
    while (at_ < text_.size()) {
      const std::size_t quote = text_.find('"', at_);
      if (quote == std::string_view::npos) break;
      std::size_t slashes = quote;
      while (slashes > at_ && text_[slashes - 1] == '\\') --slashes;
      at_ = quote + 1;
      if ((quote - slashes) % 2 == 0) return;
    }
    at_ = text_.size();
  }

  bool is_key() const {
    const std::size_t next = text_.find_first_not_of(kJsonBlanks, at_);
    return next != std::string_view::npos && text_[next] == ':';
  }

  std::string_view text_;
  std::size_t at_;
};

JsonKind kind_of_list(std::string_view text, std::size_t begin) {
  const std::size_t first = text.find_first_not_of(kJsonBlanks, begin);
  if (first == std::string_view::npos || text[first] != '{') return JsonKind::cameras;
  KeyWalk keys(text, first + 1);
  for (std::string_view key; keys.next(key);)
    if (key == "time") return JsonKind::camera_path;
  return JsonKind::cameras;
}

JsonKind kind_of_object(std::string_view text, std::size_t begin) {
  std::array<std::array<bool, 2>, kObjectKinds.size()> seen{};
  KeyWalk keys(text, begin);
  for (std::string_view key; keys.next(key);) {
    for (std::size_t i = 0; i < kObjectKinds.size(); ++i) {
      seen[i][0] = seen[i][0] || key == kObjectKinds[i].first;
      seen[i][1] = seen[i][1] || key == kObjectKinds[i].second;
      if (seen[i][0] && seen[i][1]) return kObjectKinds[i].kind;
    }
  }
  return JsonKind::other;
}

}  // namespace

nlohmann::json parse_json(std::string_view text, std::string_view source, std::size_t max_values) {
  const Shape shape = shape_of(text);
  if (shape.depth > kMaxDepth)
    fail("{}: not valid JSON: more than {} levels of brackets", source, kMaxDepth);
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

nlohmann::json parse_python_json(std::string_view text, std::string_view source) {
  try {
    return parse_json(text, source);
  } catch (const Error&) {
    const std::string quoted = with_quoted_nan(text);
    if (quoted.empty()) throw;
    try {
      return parse_json(quoted, source);
    } catch (const Error&) {  // the defect is another; its place in the file is known above
    }
    throw;
  }
}

bool is_not_finite(std::string_view word) {
  if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
  if (word.size() != 3 && word.size() != 8) return false;
  const std::string lower = lower_case(std::string(word));
  return lower == "nan" || lower == "inf" || lower == "infinity";
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
  refuse_lfs_pointer(text, path);
  return text;
}

JsonKind json_kind(std::string_view text) {
  text = without_mark(text);
  const std::size_t first = text.find_first_not_of(kJsonBlanks);
  if (first == std::string_view::npos) return JsonKind::none;
  if (text[first] == '[') return kind_of_list(text, first + 1);
  return text[first] == '{' ? kind_of_object(text, first + 1) : JsonKind::none;
}

}  // namespace qs
