// SPDX-License-Identifier: MIT
//
// Finds the files that come with the program (fonts, colour maps): ../share/quadsplat/assets beside
// an installed executable, else the source tree's assets folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace qs {

/// `name` relative to the assets folder, for example "fonts/Roboto-Regular.ttf".
std::optional<std::filesystem::path> find_asset(std::string_view name);

}  // namespace qs
