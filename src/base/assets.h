// SPDX-License-Identifier: MIT
//
// Finds files that are shipped with the program: in ../share/quadsplat of an installed executable,
// else in the source tree.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace qs {

/// The scene that comes with the program, and a picture of it.
inline constexpr std::string_view kBundledScene = "assets/plush.ply";
inline constexpr std::string_view kBundledPicture = "assets/plush.png";

/// `name`: for example "assets/fonts/Roboto-Regular.ttf" or "shaders/present.vert". Empty if
/// missing.
std::optional<std::filesystem::path> find_asset(std::string_view name);

/// The font of the window and of legends. Empty if it is missing, which a line on stderr says once:
/// the letters of Dear ImGui's own font are smaller.
std::optional<std::filesystem::path> find_font();

// Finds the folder of the running program, so that an installed tree can be moved.

/// Folder of the executable; empty if the system does not report it.
std::filesystem::path program_folder();

}  // namespace qs
