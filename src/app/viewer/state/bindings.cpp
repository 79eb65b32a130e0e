// SPDX-License-Identifier: MIT
#include "app/viewer/state/bindings.h"

#include <algorithm>
#include <array>
#include <vector>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

namespace qs {
namespace {

using namespace action;

constexpr int kCtrl = GLFW_MOD_CONTROL, kShift = GLFW_MOD_SHIFT;

std::vector<Binding> make_bindings() {
  std::vector<Binding> rows;
  const auto add = [&rows](int key, int mods, Menu menu, std::string help, Action action) {
    rows.push_back({key, mods, menu, std::move(help), std::move(action), std::nullopt, nullptr});
  };
  const auto panel = [&rows](int key, int mods, std::string help, bool Panels::*which) {
    rows.push_back(
        {key, mods, Menu::view, std::move(help), TogglePanel{which}, std::nullopt, which});
  };

  panel(GLFW_KEY_O, kCtrl, "Open a file", &Panels::open);
  rows.back().menu = Menu::file;
  add(GLFW_KEY_F5, 0, Menu::file, "Reload", Reload{});
  add(GLFW_KEY_Y, 0, Menu::file, "Read with other axes", NextAxes{});
  add(GLFW_KEY_F12, 0, Menu::file, "Screenshot of the window", TakeScreenshot{true});
  add(GLFW_KEY_F12, kCtrl, Menu::file, "Screenshot of the picture", TakeScreenshot{false});
  add(GLFW_KEY_Q, kCtrl, Menu::file, "Quit", Quit{});

  panel(GLFW_KEY_F10, 0, "Performance", &Panels::hud);
  panel(GLFW_KEY_I, 0, "Scene and render settings", &Panels::info);
  panel(GLFW_KEY_B, 0, "Inspector: boxes of a Gaussian", &Panels::inspector);
  panel(GLFW_KEY_F1, 0, "Help", &Panels::help);
  panel(GLFW_KEY_TAB, 0, "All windows", &Panels::all);
  add(GLFW_KEY_H, 0, Menu::view, "Heat map", ToggleHeatmap{});
  add(GLFW_KEY_H, kShift, Menu::view, "Next heat map", NextHeatmap{});
  add(GLFW_KEY_EQUAL, 0, Menu::view, "Larger splats", ScaleSplats{1.1f});
  add(GLFW_KEY_MINUS, 0, Menu::view, "Smaller splats", ScaleSplats{1 / 1.1f});
  add(GLFW_KEY_F11, 0, Menu::view, "Full screen", ToggleFullscreen{});

  panel(GLFW_KEY_L, 0, "Cameras and path", &Panels::cameras);
  rows.back().menu = Menu::camera;
  add(GLFW_KEY_LEFT_BRACKET, 0, Menu::camera, "Previous camera", StepCamera{CameraStep::previous});
  add(GLFW_KEY_RIGHT_BRACKET, 0, Menu::camera, "Next camera", StepCamera{CameraStep::next});
  add(GLFW_KEY_LEFT_BRACKET, kShift, Menu::camera, "First camera", StepCamera{CameraStep::first});
  add(GLFW_KEY_RIGHT_BRACKET, kShift, Menu::camera, "Last camera", StepCamera{CameraStep::last});
  add(GLFW_KEY_N, 0, Menu::camera, "Nearest camera", StepCamera{CameraStep::nearest});
  add(GLFW_KEY_G, 0, Menu::camera, "Photograph of this camera", TogglePhotograph{});
  panel(GLFW_KEY_O, 0, "Cameras in the scene", &Panels::frusta);
  rows.back().menu = Menu::camera;
  add(GLFW_KEY_F, 0, Menu::camera, "Frame the scene", FrameScene{});
  add(GLFW_KEY_HOME, 0, Menu::camera, "First view", GoHome{});
  add(GLFW_KEY_V, 0, Menu::camera, "Orbit or fly", ToggleNavigation{});
  add(GLFW_KEY_C, kCtrl, Menu::camera, "Copy the camera as JSON", CopyCamera{});
  add(GLFW_KEY_V, kCtrl, Menu::camera, "Paste a camera", PasteCamera{});
  add(GLFW_KEY_K, 0, Menu::camera, "Set a keyframe", AddKeyframe{});
  add(GLFW_KEY_SPACE, 0, Menu::camera, "Play the path", TogglePlayback{});

  for (CullMode mode = 1; mode <= kCullerCount; ++mode) {
    add(GLFW_KEY_0 + mode, 0, Menu::mode, mode_name(mode), SetMode{mode});
  }
  add(GLFW_KEY_GRAVE_ACCENT, 0, Menu::none, "Previous mode, while held", PeekPreviousMode{true});
  rows.back().on_release = PeekPreviousMode{false};

  panel(GLFW_KEY_C, 0, "Split: beside another mode", &Panels::split);
  rows.back().menu = Menu::mode;
  add(GLFW_KEY_C, kShift, Menu::mode, "Next view of the split", NextSplitView{});
  add(GLFW_KEY_X, 0, Menu::mode, "Flip the split", FlipSplit{});

  add(GLFW_KEY_Z, 0, Menu::measure, "Record a zoom", ToggleZoomRecorder{});
  add(GLFW_KEY_P, 0, Menu::measure, "Bench this view", BenchView{});
  add(GLFW_KEY_0, 0, Menu::measure, "Compare with the reference", AskOracle{});
  add(GLFW_KEY_0, kShift, Menu::measure, "The same around the cursor", AskOracle{true});
  return rows;
}

constexpr std::array kFlyKeys = {
    FlyKey{GLFW_KEY_W, {0, 0, 1}, "forward"}, FlyKey{GLFW_KEY_S, {0, 0, -1}, "back"},
    FlyKey{GLFW_KEY_A, {-1, 0, 0}, "left"},   FlyKey{GLFW_KEY_D, {1, 0, 0}, "right"},
    FlyKey{GLFW_KEY_Q, {0, 1, 0}, "down"},    FlyKey{GLFW_KEY_E, {0, -1, 0}, "up"},
};

constexpr std::array kGestures = {
    Gesture{"Left drag", "orbit (fly: look around)"},
    Gesture{"Right drag", "pan (fly: look around)"},
    Gesture{"Middle drag", "pan"},
    Gesture{"Wheel", "nearer, farther"},
    Gesture{"Shift+Wheel", "field of view"},
    Gesture{"Ctrl+Wheel", "roll"},
    Gesture{"Click", "inspector: what makes this pixel"},
    Gesture{"Double click", "pivot at what is under the cursor"},
    Gesture{"Shift, Alt", "fly 5 times faster, slower"},
    Gesture{"Drop a file", "a scene, a folder, cameras"},
};

int main_row(int key) {
  const bool keypad_digit = key >= GLFW_KEY_KP_0 && key <= GLFW_KEY_KP_9;
  return keypad_digit ? key - GLFW_KEY_KP_0 + GLFW_KEY_0 : key;
}

}  // namespace

std::span<const Binding> bindings() {
  static const std::vector<Binding> rows = make_bindings();
  return rows;
}

std::span<const FlyKey> fly_keys() { return kFlyKeys; }
std::span<const Gesture> gestures() { return kGestures; }

std::string key_name(int key, int mods) {
  std::string text;
  if ((mods & kCtrl) != 0) text += "Ctrl+";
  if ((mods & GLFW_MOD_ALT) != 0) text += "Alt+";
  if ((mods & kShift) != 0) text += "Shift+";
  switch (key) {
    case GLFW_KEY_TAB:
      return text + "Tab";
    case GLFW_KEY_HOME:
      return text + "Home";
    case GLFW_KEY_SPACE:
      return text + "Space";
    default:
      break;
  }
  if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F25)
    return text + fmt::format("F{}", key - GLFW_KEY_F1 + 1);
  return text + static_cast<char>(key);  // GLFW names printable keys by their character
}

const Binding* find_binding(int key, int mods) {
  const std::span<const Binding> rows = bindings();
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const Binding& row) {
    return row.key == main_row(key) && row.mods == mods;
  });
  return found == rows.end() ? nullptr : &*found;
}

}  // namespace qs
