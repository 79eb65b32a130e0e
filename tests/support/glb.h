// SPDX-License-Identifier: MIT
//
// Splits a .glb and builds one, for tests that change its JSON.
#pragma once

#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "io/bytes/json_text.h"
#include "support/corpus.h"

namespace qs::test {

struct Glb {
  nlohmann::json description;
  std::vector<std::byte> binary;
};

inline Glb open_glb(const std::vector<std::byte>& bytes) {
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, 4);
  const char* const text = reinterpret_cast<const char*>(bytes.data()) + 20;
  return {parse_json(std::string(text, length), "test"),
          {bytes.begin() + 20 + length + 8, bytes.end()}};
}

inline std::vector<std::byte> make_glb(const Glb& glb) {
  std::string text = glb.description.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::size_t numbers[] = {0x46546C67, 2, 28 + text.size() + glb.binary.size(), text.size(),
                                 0x4E4F534A};
  const std::size_t chunk[] = {glb.binary.size(), 0x004E4942};
  std::string file;
  const auto put = [&file](std::size_t value) {
    for (const int shift : {0, 8, 16, 24}) file += static_cast<char>(value >> shift & 255);
  };
  for (const std::size_t value : numbers) put(value);
  file += text;
  for (const std::size_t value : chunk) put(value);
  file.append(reinterpret_cast<const char*>(glb.binary.data()), glb.binary.size());
  return to_bytes(file);
}

}  // namespace qs::test
