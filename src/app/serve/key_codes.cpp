// SPDX-License-Identifier: MIT
#include "app/serve/key_codes.h"

#include <algorithm>
#include <array>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace qs {
namespace {

struct KeyCode {
  std::string_view code;
  int key;
};

constexpr std::array kKeyCodes = {
    KeyCode{"Space", GLFW_KEY_SPACE},
    KeyCode{"Minus", GLFW_KEY_MINUS},
    KeyCode{"Equal", GLFW_KEY_EQUAL},
    KeyCode{"BracketLeft", GLFW_KEY_LEFT_BRACKET},
    KeyCode{"BracketRight", GLFW_KEY_RIGHT_BRACKET},
    KeyCode{"Backquote", GLFW_KEY_GRAVE_ACCENT},
    KeyCode{"Home", GLFW_KEY_HOME},
    KeyCode{"Backspace", GLFW_KEY_BACKSPACE},
    KeyCode{"F10", GLFW_KEY_F10},
    KeyCode{"NumpadAdd", GLFW_KEY_KP_ADD},
    KeyCode{"NumpadSubtract", GLFW_KEY_KP_SUBTRACT},
};

}  // namespace

int key_of_code(std::string_view code) {
  const auto ends_with = [&](std::string_view start, char first, char last) {
    return code.size() == start.size() + 1 && code.starts_with(start) && code.back() >= first &&
           code.back() <= last;
  };
  if (ends_with("Key", 'A', 'Z')) return GLFW_KEY_A + (code.back() - 'A');
  if (ends_with("Digit", '0', '9')) return GLFW_KEY_0 + (code.back() - '0');
  if (ends_with("Numpad", '0', '9')) return GLFW_KEY_KP_0 + (code.back() - '0');
  if (ends_with("F", '1', '9')) return GLFW_KEY_F1 + (code.back() - '1');
  const auto found = std::find_if(kKeyCodes.begin(), kKeyCodes.end(),
                                  [&](const KeyCode& row) { return row.code == code; });
  return found == kKeyCodes.end() ? 0 : found->key;
}

}  // namespace qs
