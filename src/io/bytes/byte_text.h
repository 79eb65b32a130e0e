// SPDX-License-Identifier: MIT
//
// Bytes as text, and text for messages.
#pragma once

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace qs {

/// The bytes of a file or of a part of it.
using ByteSpan = std::span<const std::byte>;

inline std::string_view text_of(ByteSpan bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The text without the byte order mark of UTF-8, which editors of Windows write.
inline std::string_view without_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  return text.starts_with(kMark) ? text.substr(kMark.size()) : text;
}

inline std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// A text of a file for a message: in one line, unprintable characters replaced, and at most
/// `longest` characters of it, after which "..." follow.
inline std::string printable(std::string_view text, std::size_t longest = 60) {
  std::string shown(text.substr(0, longest));
  std::ranges::replace_if(
      shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  return text.size() > longest ? shown + "..." : shown;
}

}  // namespace qs
