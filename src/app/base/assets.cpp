// SPDX-License-Identifier: MIT
#include "app/base/assets.h"

#include <system_error>

#include "io/bytes/program_folder.h"

namespace qs {

std::optional<std::filesystem::path> find_asset(std::string_view name) {
  const std::filesystem::path source_tree = QUADSPLAT_SOURCE_TREE;
  for (const auto& folder : {program_folder() / "../share/quadsplat", source_tree}) {
    std::error_code error;
    if (std::filesystem::is_regular_file(folder / name, error)) return folder / name;
  }
  return std::nullopt;
}

}  // namespace qs
