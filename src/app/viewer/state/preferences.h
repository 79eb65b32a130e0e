// SPDX-License-Identifier: MIT
//
// What the viewer keeps from one run to the next: the window's size, switches, recent files, the
// last view of each scene. A JSON file in $XDG_CONFIG_HOME/quadsplat (default: ~/.config).
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "app/viewer/state/viewer.h"

namespace qs {

struct Preferences {
  int width = 1280, height = 720;  ///< of the window, screen coordinates
  bool vsync = true, on_demand = true, reduce_when_moving = true;
  Panels panels;
  Navigation navigation = Navigation::orbit;
  std::vector<std::filesystem::path> recent;
  std::map<std::string, std::string> cameras;  ///< Viewer::last_views
};

/// Copies preferences into a Viewer, and back.
void use_preferences(Viewer& viewer, const Preferences& preferences);
Preferences preferences_of(const Viewer& viewer, glm::ivec2 window_size);

/// viewer.json in the user's configuration folder; empty if there is no home folder.
std::filesystem::path preferences_file();

/// The defaults if there is no file; also if it is damaged, which `problem` then says.
Preferences read_preferences(const std::filesystem::path& file, std::string& problem);

/// Makes the folder if needed. Throws Error(input).
void write_preferences(const std::filesystem::path& file, const Preferences& preferences);

}  // namespace qs
