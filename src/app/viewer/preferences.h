// SPDX-License-Identifier: MIT
//
// The data that the viewer keeps from one run to the next: the window's size, switches, recent
// files, the last view, bookmarks, keyframes and crops of each scene, the mode and the heat map. A
// JSON file in $XDG_CONFIG_HOME/quadsplat (default: ~/.config). To keep another member of Viewer: a
// line of for_each_preference().
#pragma once

#include <filesystem>
#include <string>

#include "app/viewer/state/viewer.h"

namespace qs {

/// viewer.json in the user's configuration folder; empty if there is no home folder.
std::filesystem::path preferences_file();

/// Sets the members that the file contains; `window_size` in screen units. If there is no file,
/// nothing changes and the result is "". If the file is damaged, nothing changes and the result is
/// a sentence that says so.
std::string read_preferences(const std::filesystem::path& file, Viewer& viewer,
                             glm::ivec2& window_size);

/// Sets the members that the text contains. Throws std::exception and changes nothing if it is
/// damaged.
void parse_preferences(const std::string& text, Viewer& viewer, glm::ivec2& window_size);

/// The text that parse_preferences() reads.
std::string format_preferences(const Viewer& viewer, glm::ivec2 window_size);

/// Makes the folder if needed. Throws Error(input).
void write_preferences(const std::filesystem::path& file, const Viewer& viewer,
                       glm::ivec2 window_size);

}  // namespace qs
