// SPDX-License-Identifier: MIT
#include "app/viewer/commands/keys.h"

#include <algorithm>
#include <array>
#include <iterator>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include "base/fail.h"

namespace qs {
namespace {

struct Name {
  int code;
  const char* text;
};
constexpr Name kModifiers[] = {
    {GLFW_MOD_CONTROL, "Ctrl+"}, {GLFW_MOD_ALT, "Alt+"}, {GLFW_MOD_SHIFT, "Shift+"}};
constexpr Name kNamedKeys[] = {
    {GLFW_KEY_TAB, "Tab"},       {GLFW_KEY_HOME, "Home"},     {GLFW_KEY_BACKSPACE, "Backspace"},
    {GLFW_KEY_SPACE, "Space"},   {GLFW_KEY_ESCAPE, "Escape"}, {GLFW_KEY_ENTER, "Enter"},
    {GLFW_KEY_DELETE, "Delete"}, {GLFW_KEY_LEFT, "Left"},     {GLFW_KEY_RIGHT, "Right"},
    {GLFW_KEY_UP, "Up"},         {GLFW_KEY_DOWN, "Down"}};

constexpr std::array kFlyKeys = {
    FlyKey{GLFW_KEY_W, {0, 0, 1}, "forward"}, FlyKey{GLFW_KEY_S, {0, 0, -1}, "back"},
    FlyKey{GLFW_KEY_A, {-1, 0, 0}, "left"},   FlyKey{GLFW_KEY_D, {1, 0, 0}, "right"},
    FlyKey{GLFW_KEY_Q, {0, 1, 0}, "down"},    FlyKey{GLFW_KEY_E, {0, -1, 0}, "up"},
};

constexpr std::array kGestures = {
    Gesture{"Left drag", "orbit (fly: look around)"},
    Gesture{"Right drag", "pan (fly: look around)"},
    Gesture{"Middle drag", "pan"},
    Gesture{"Wheel", "nearer, farther (fly: faster, slower)"},
    Gesture{"Shift+Wheel", "field of view"},
    Gesture{"Ctrl+Wheel", "roll"},
    Gesture{"Click", "inspector: what makes this pixel; a tool: sets a point"},
    Gesture{"Double click", "go to the point under the cursor"},
    Gesture{"Shift, Alt", "fly 5 times faster, slower"},
    Gesture{"Drop a file", "a scene, a folder, cameras"},
};

constexpr PadControl kPadControls[] = {
    {{"Left stick", "fly; pressed: 5 times faster"}},
    {{"Triggers", "fly down, fly up"}},
    {{"Right stick", "look around"}},
    {{"Left bumper", "Mode before in the list"}, GLFW_GAMEPAD_BUTTON_LEFT_BUMPER},
    {{"Right bumper", "Next mode in the list"}, GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER},
    {{"A", "First view"}, GLFW_GAMEPAD_BUTTON_A},
    {{"B", "Back to the view before"}, GLFW_GAMEPAD_BUTTON_B},
    {{"X", "Heat map"}, GLFW_GAMEPAD_BUTTON_X},
    {{"Y", "FPS of all modes"}, GLFW_GAMEPAD_BUTTON_Y},
    {{"D-pad left", "Previous camera"}, GLFW_GAMEPAD_BUTTON_DPAD_LEFT},
    {{"D-pad right", "Next camera"}, GLFW_GAMEPAD_BUTTON_DPAD_RIGHT},
    {{"Start", "Keys and mouse"}, GLFW_GAMEPAD_BUTTON_START}};

}  // namespace

std::string key_name(int key, int mods) {
  std::string text;
  for (const Name& modifier : kModifiers)
    if ((mods & modifier.code) != 0) text += modifier.text;
  for (const Name& named : kNamedKeys)
    if (key == named.code) return text + named.text;
  if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F25)
    return text + fmt::format("F{}", key - GLFW_KEY_F1 + 1);
  return text + static_cast<char>(key);  // GLFW numbers printable keys by their character
}

KeyPress parse_key(const std::string& name) {
  KeyPress press;
  std::string rest = name;
  for (const Name& modifier : kModifiers) {
    if (!rest.starts_with(modifier.text)) continue;
    press.mods |= modifier.code;
    rest.erase(0, std::string_view(modifier.text).size());
  }
  for (press.key = GLFW_KEY_SPACE; press.key <= GLFW_KEY_LAST; ++press.key)
    if (key_name(press.key) == rest) return press;
  fail("there is no key '{}'", name);
}

std::span<const FlyKey> fly_keys() { return kFlyKeys; }
std::span<const Gesture> gestures() { return kGestures; }
std::span<const PadControl> pad_controls() { return kPadControls; }

}  // namespace qs
