// SPDX-License-Identifier: MIT
//
// The one table of keys. Input, menus and the help window all walk it. To bind a key: a row in
// bindings.cpp; the feature's action must exist.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "app/viewer/state/actions.h"

namespace qs {

enum class Menu { file, view, camera, mode, measure, none };

/// Index = Menu; `none` has no menu.
inline constexpr const char* kMenuNames[] = {"File", "View", "Camera", "Mode", "Measure"};

struct Binding {
  int key;   ///< GLFW_KEY_*
  int mods;  ///< GLFW_MOD_SHIFT, _CONTROL, _ALT, exactly these
  Menu menu;
  std::string help;  ///< what it does, in a few words: the menu's label too
  Action action;
  std::optional<Action> on_release;  ///< for keys that work while they are held
  bool Panels::*checked = nullptr;   ///< the menu shows a tick when it is true
};

std::span<const Binding> bindings();

/// A key that moves the camera while it is held, whatever the modifiers.
struct FlyKey {
  int key;
  glm::dvec3 direction;  ///< right, down, forward
  const char* help;
};
std::span<const FlyKey> fly_keys();

/// What the mouse does, for the help window.
struct Gesture {
  const char *keys, *help;
};
std::span<const Gesture> gestures();

/// "Ctrl+Shift+K" as keyboards print it.
std::string key_name(int key, int mods = 0);

/// The row for a key, digits of the keypad taken for those of the main row; null when there is
/// none.
const Binding* find_binding(int key, int mods);

}  // namespace qs
