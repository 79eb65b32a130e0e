// SPDX-License-Identifier: MIT
//
// What the viewer remembers from one run to the next: the window, switches, recent files, the last
// camera of each scene. A JSON file in $XDG_CONFIG_HOME/quadsplat (default: ~/.config).
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
  std::map<std::string, std::string> cameras;  ///< scene file -> camera as JSON
};

/// viewer.json in the user's configuration folder; empty when there is no home.
std::filesystem::path preferences_file();

/// A missing file gives the defaults. A damaged one too, and `problem` gets a sentence.
Preferences read_preferences(const std::filesystem::path& file, std::string& problem);

/// The same from the text of the file `source`.
Preferences parse_preferences(const std::string& text, const std::string& source,
                              std::string& problem);
std::string format_preferences(const Preferences& preferences);

/// Makes the folder if needed. Throws Error(input).
void write_preferences(const std::filesystem::path& file, const Preferences& preferences);

}  // namespace qs
