// SPDX-License-Identifier: MIT
//
// Finds the files that come with the program: ../share/quadsplat beside an installed executable,
// else the source tree.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace qs {

/// For example "assets/fonts/Roboto-Regular.ttf", "shaders/present.vert".
std::optional<std::filesystem::path> find_asset(std::string_view name);

}  // namespace qs
