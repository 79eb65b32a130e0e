// SPDX-License-Identifier: MIT
//
// The table of the commands of keys and menus. Input, menus and the help window read it.
// To add a command: one row in commands.cpp. If it takes long, its function is a background job in
// a file of its own in this folder (see bench_view.cpp). docs/viewer.md lists the keys.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/viewer/state/action.h"

namespace qs {

enum class Menu { file, edit, view, camera, lens, mode, measure, train, window, help, none };

/// Index = Menu; `none` has no menu.
inline constexpr const char* kMenuNames[] = {"File", "Edit",    "View",  "Camera", "Lens",
                                             "Mode", "Measure", "Train", "Window", "Help"};

struct KeyCommand {
  int key;   ///< GLFW_KEY_*
  int mods;  ///< exactly these of GLFW_MOD_SHIFT, _CONTROL, _ALT
  Menu menu;
  std::string help;  ///< the menu's label too
  Action action;
  Action on_release = {};                              ///< of keys that act while they are held
  std::function<bool(const Viewer&)> is_checked = {};  ///< true if the menu shows a tick
  const char* tooltip = nullptr;                       ///< in the menu
  /// also works without a scene; else the menu's entry is gray without one
  bool without_scene = false;
  bool line_above = false;        ///< in the menu
  bool opens_dialog = false;      ///< "..." follows the menu's label
  bool Panels::*panel = nullptr;  ///< that the command opens and closes; null: none
};

std::span<const KeyCommand> key_commands();

/// The command with this KeyCommand::help; null if there is none.
const KeyCommand* find_command(std::string_view help);

/// "Flip the split (X)": the help and the key of the command with this KeyCommand::help.
std::string command_hint(std::string_view help);

/// The label in the menu.
std::string menu_label(const KeyCommand& command);

/// True if `about` has every word of the text, in letters of either case.
bool has_words(const std::string& about, const std::string& text);

/// The commands that act now and whose menu, label or key contain every word of the text.
std::vector<const KeyCommand*> find_commands(const std::string& text, const Viewer& viewer);

/// The command of a key; digits, plus and minus of the keypad count as keys of the main row. Null
/// if the key has no command.
const KeyCommand* find_key_command(int key, int mods);

}  // namespace qs
