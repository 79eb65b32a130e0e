// SPDX-License-Identifier: MIT
//
// Takes a .glb apart and builds one, for tests that change its description.
#pragma once

#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace qs::test {

struct Glb {
  nlohmann::json description;
  std::vector<std::byte> binary;
};

inline Glb open_glb(const std::vector<std::byte>& bytes) {
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, 4);
  const char* const text = reinterpret_cast<const char*>(bytes.data()) + 20;
  return {nlohmann::json::parse(std::string(text, length)),
          {bytes.begin() + 20 + length + 8, bytes.end()}};
}

inline std::vector<std::byte> make_glb(const Glb& glb) {
  std::string text = glb.description.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::vector<std::byte> bytes;
  const auto put = [&bytes](const void* data, std::size_t size) {
    const auto* const begin = static_cast<const std::byte*>(data);
    bytes.insert(bytes.end(), begin, begin + size);
  };
  const auto number = [&put](std::size_t value) {
    const auto bits = static_cast<std::uint32_t>(value);
    put(&bits, sizeof bits);
  };
  for (const std::size_t value :
       {std::size_t{0x46546C67}, std::size_t{2}, 28 + text.size() + glb.binary.size(), text.size(),
        std::size_t{0x4E4F534A}}) {
    number(value);
  }
  put(text.data(), text.size());
  number(glb.binary.size());
  number(0x004E4942);
  put(glb.binary.data(), glb.binary.size());
  return bytes;
}

}  // namespace qs::test
