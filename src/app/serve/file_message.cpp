// SPDX-License-Identifier: MIT
#include "app/serve/file_message.h"

#include <algorithm>
#include <cstring>
#include <string_view>

namespace qs {
namespace {

template <class T>
void append(std::string& message, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));  // little-endian, see picture_message.cpp
  message.append(bytes, sizeof(T));
}

bool is_harmless(char c) {
  const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  return letter || std::string_view("._- ").find(c) != std::string_view::npos ||
         static_cast<unsigned char>(c) >= 0x80;
}

}  // namespace

std::string harmless_name(const std::string& name) {
  std::string result = name.substr(name.find_last_of("/\\") + 1);
  std::replace_if(
      result.begin(), result.end(), [](char c) { return !is_harmless(c); }, '_');
  result.erase(0, result.find_first_not_of(". "));
  constexpr std::size_t kMost = 200;
  if (result.size() > kMost) result.erase(0, result.size() - kMost);
  return result.empty() ? "file" : result;
}

std::string file_message(const SentFile& file, std::uint32_t number, std::size_t begin) {
  const std::string& bytes = *file.bytes;
  const std::size_t count = std::min(kFilePart, bytes.size() - begin);
  std::string message;
  append(message, std::uint8_t{2});
  append(message, static_cast<std::uint8_t>(begin + count == bytes.size() ? 4 : 0));
  append(message, static_cast<std::uint16_t>(file.name.size()));
  append(message, number);
  append(message, std::uint64_t{bytes.size()});
  return message + file.name + bytes.substr(begin, count);
}

}  // namespace qs
