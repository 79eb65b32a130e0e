// SPDX-License-Identifier: MIT
#include "app/session/shot.h"

#include <cctype>

#include <fmt/format.h>

namespace qs {

std::string safe_file_name(std::string name) {
  for (char& c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80 && !std::isalnum(byte) && c != '-' && c != '.' && c != '_') c = '_';
  }
  return name;
}

std::filesystem::path with_word(const std::filesystem::path& path, const std::string& word) {
  std::filesystem::path result = path;
  result.replace_filename(fmt::format("{}_{}{}", path.stem().string(), safe_file_name(word),
                                      path.extension().string()));
  return result;
}

std::filesystem::path with_shot(const std::filesystem::path& path, const Shot& shot) {
  if (shot.number < 0) return path;
  const std::filesystem::path numbered = with_word(path, fmt::format("{:04}", shot.number));
  return shot.camera.name.empty() ? numbered : with_word(numbered, shot.camera.name);
}

}  // namespace qs
