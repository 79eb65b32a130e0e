// SPDX-License-Identifier: MIT
//
// Finds files that are shipped with the program: in ../share/quadsplat of an installed executable,
// else in the source tree.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace qs {

/// `name`: for example "assets/fonts/Roboto-Regular.ttf" or "shaders/present.vert". Empty if
/// missing.
std::optional<std::filesystem::path> find_asset(std::string_view name);

}  // namespace qs
