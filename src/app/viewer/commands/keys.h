// SPDX-License-Identifier: MIT
//
// Names of keys, the keys that fly the camera, gestures of the mouse and the gamepad. Other keys:
// commands.h.
#pragma once

#include <span>
#include <string>

#include <glm/vec3.hpp>

namespace qs {

struct KeyPress {
  int key = 0;   ///< GLFW_KEY_*
  int mods = 0;  ///< GLFW_MOD_SHIFT, _CONTROL, _ALT
};

/// "Ctrl+Shift+K" as printed on keyboards.
std::string key_name(int key, int mods = 0);

/// The key that key_name() prints as `name`. Throws Error(input).
KeyPress parse_key(const std::string& name);

/// A key that moves the camera while it is held, with any modifiers.
struct FlyKey {
  int key;
  glm::dvec3 direction;  ///< right, down, forward
  const char* help;
};
std::span<const FlyKey> fly_keys();

/// A gesture of the mouse and its effect, for the help window.
struct Gesture {
  const char *keys, *help;
};
std::span<const Gesture> gestures();

/// A control of a gamepad. A button runs the command with its help.
struct PadControl : Gesture {
  int button = -1;  ///< GLFW_GAMEPAD_BUTTON_*; -1: a stick or a trigger
};
std::span<const PadControl> pad_controls();

}  // namespace qs
