// SPDX-License-Identifier: MIT
// Compiled alone: it has a macro of its own.
#include "base/assets.h"

#include <cstdio>
#include <mutex>
#include <system_error>

#include <fmt/format.h>

#include "base/path_kind.h"

namespace qs {

std::optional<std::filesystem::path> find_asset(std::string_view name) {
  const std::filesystem::path source_tree = QUADSPLAT_SOURCE_TREE;
  for (const auto& folder : {program_folder() / "../share/quadsplat", source_tree})
    if (is_file(folder / name)) return folder / name;
  return std::nullopt;
}

std::optional<std::filesystem::path> find_font() {
  static constexpr const char* kFont = "assets/fonts/Roboto-Regular.ttf";
  const auto file = find_asset(kFont);
  static std::once_flag said;
  if (!file)
    std::call_once(said, [] {
      fmt::print(stderr, "quadsplat: {} is not beside the program: letters are small\n", kFont);
    });
  return file;
}

std::filesystem::path program_folder() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
}

}  // namespace qs
