// SPDX-License-Identifier: MIT
#include "io/bytes/json_kind.h"

#include <array>
#include <cstddef>

namespace qs {
namespace {

// An object with both keys has the kind.
struct KindRow {
  JsonKind kind;
  std::string_view first, second;
};
constexpr std::array kObjectKinds = {KindRow{JsonKind::transforms, "frames", "frames"},
                                     KindRow{JsonKind::sog, "means", "quats"},
                                     KindRow{JsonKind::streamed_sog, "filenames", "tree"},
                                     KindRow{JsonKind::gltf, "asset", "meshes"}};

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

JsonKind json_kind(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kJsonBlanks);
  if (first == std::string_view::npos) return JsonKind::none;
  if (text[first] == '[') return kind_of_list(text, first + 1);
  return text[first] == '{' ? kind_of_object(text, first + 1) : JsonKind::none;
}

}  // namespace qs
