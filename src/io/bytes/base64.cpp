// SPDX-License-Identifier: MIT
#include "io/bytes/base64.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "base/fail.h"

namespace qs {
namespace {

constexpr std::string_view kDigits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::uint8_t kNoDigit = 64;

constexpr std::array<std::uint8_t, 256> make_values() {
  std::array<std::uint8_t, 256> values{};
  for (auto& value : values) value = kNoDigit;
  for (std::size_t i = 0; i < kDigits.size(); ++i)
    values[static_cast<unsigned char>(kDigits[i])] = static_cast<std::uint8_t>(i);
  return values;
}
constexpr std::array<std::uint8_t, 256> kValues = make_values();

}  // namespace

std::string base64(std::string_view bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (k < left ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= left ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

Array<std::byte> decode_data_uri(std::string_view uri, const std::string& where) {
  constexpr std::string_view kMarker = ";base64,";
  const std::size_t marker = uri.substr(0, 256).find(kMarker);
  if (marker == uri.npos) fail("{}: a data URI that is not base64", where);
  std::string_view text = uri.substr(marker + kMarker.size());
  if (text.size() % 4 != 0) fail("{}: damaged base64: {} characters", where, text.size());
  for (int i = 0; i < 2 && text.ends_with('='); ++i) text.remove_suffix(1);

  Array<std::byte> bytes(text.size() * 3 / 4);
  std::uint32_t bits = 0;
  int count = 0;
  std::size_t written = 0;
  for (const char c : text) {
    const std::uint8_t value = kValues[static_cast<unsigned char>(c)];
    if (value == kNoDigit) fail("{}: damaged base64", where);
    bits = bits << 6 | value;
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes[written++] = static_cast<std::byte>(bits >> count & 255);
  }
  return bytes;
}

}  // namespace qs
