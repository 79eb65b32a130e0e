// SPDX-License-Identifier: MIT
#include "app/viewer/commands/input.h"

#include <algorithm>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <glm/geometric.hpp>

#include "app/viewer/commands/commands.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/commands/keys.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/select_actions.h"

namespace qs {
namespace {

constexpr int kKnownMods = GLFW_MOD_SHIFT | GLFW_MOD_CONTROL | GLFW_MOD_ALT;
constexpr double kDoubleClickSeconds = 0.35, kDoubleClickPixels = 6;
constexpr double kClickPixels = 3;  ///< a larger distance between press and release is a drag
constexpr double kFast = 5, kSlow = 0.2;
constexpr double kDeadZone = 0.15;  ///< around the rest of sticks and triggers
constexpr double kPadTurn = 2;      ///< radians per second

// Keys have no other effect while a dialog takes the keyboard. The state is checked when the action
// is applied, because the key that opens the dialog may be an action of the same poll.
Action unless_typing(Action action) {
  return [action = std::move(action)](Viewer& viewer, Host& host) {
    if (!viewer.has_dialog()) action(viewer, host);
  };
}

// A click is the tool's while one is chosen.
Action unless_with_tool(Action action) {
  return [action = std::move(action)](Viewer& viewer, Host& host) {
    if (!viewer.has_tool()) action(viewer, host);
  };
}

void click(Viewer& viewer, Host& host, glm::dvec2 pixel) {
  viewer.cross.reset();
  if (viewer.measures.picks) return action::measure_pixel(viewer, host, pixel);
  if (!viewer.selecting.tool) action::inspect_pixel(viewer, host, pixel);
}

// The place of a stick without its dead zone: the rest is rescaled, to a length of at most 1.
glm::dvec2 without_dead_zone(glm::dvec2 at) {
  const double length = glm::length(at);
  if (length <= kDeadZone) return glm::dvec2(0);
  return (std::min(length, 1.0) - kDeadZone) / (1 - kDeadZone) / length * at;
}

}  // namespace

PadMotion pad_motion(const GLFWgamepadstate& pad) {
  const auto stick = [&](int x) { return without_dead_zone({pad.axes[x], pad.axes[x + 1]}); };
  const auto trigger = [&](int x) { return without_dead_zone({0.5f * (pad.axes[x] + 1), 0}).x; };
  const glm::dvec2 left = stick(GLFW_GAMEPAD_AXIS_LEFT_X);
  const double up =
      trigger(GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER) - trigger(GLFW_GAMEPAD_AXIS_LEFT_TRIGGER);
  const double factor = pad.buttons[GLFW_GAMEPAD_BUTTON_LEFT_THUMB] == GLFW_PRESS ? kFast : 1;
  return {factor * glm::dvec3(left.x, -up, -left.y), kPadTurn * stick(GLFW_GAMEPAD_AXIS_RIGHT_X)};
}

void Input::gamepad(const GLFWgamepadstate* pad, double seconds, Actions& actions) {
  has_gamepad_ = pad != nullptr;
  const PadMotion motion = has_gamepad_ ? pad_motion(*pad) : PadMotion();
  if (motion.direction != glm::dvec3(0))
    actions.push_back(unless_typing(call(action::fly, motion.direction, 1.0)));
  if (motion.turn != glm::dvec2(0))
    actions.push_back(unless_typing([by = seconds * motion.turn](Viewer& v, Host&) {
      action::look(v, -by * v.camera.focal_px);
    }));
  for (const PadControl& control : pad_controls()) {
    if (control.button < 0) continue;
    const int code = -1 - control.button;
    if (!has_gamepad_ || pad->buttons[control.button] != GLFW_PRESS) {
      held_.erase(code);
    } else if (held_.insert(code).second) {
      actions.push_back(unless_typing(find_command(control.help)->action));
    }
  }
}

void Input::key(int key, bool down, bool repeat, int mods, bool captured, Actions& actions) {
  mods_ = mods & kKnownMods;
  if (!down) {
    // Its press was not captured, so the release counts even if a panel captures input now.
    if (held_.erase(key) == 0) return;
    const KeyCommand* row = find_key_command(key, 0);
    if (row != nullptr && row->on_release) actions.push_back(row->on_release);
    return;
  }
  if (captured) return;
  const KeyCommand* row = find_key_command(key, mods_);
  if (row != nullptr && row->on_release && repeat) return;
  held_.insert(key);
  if (row != nullptr) actions.push_back(unless_typing(row->action));
}

void Input::button(int button, bool down, bool captured, double now, Actions& actions) {
  if (!down) {
    if (button != dragged_) return;
    dragged_.reset();
    if (button != GLFW_MOUSE_BUTTON_LEFT) return;
    actions.push_back(call(action::end_shape));
    if (glm::distance(cursor_, last_press_) < kClickPixels)
      actions.push_back(call(click, picture_cursor()));
    return;
  }
  if (captured) return;
  dragged_ = button;
  if (button != GLFW_MOUSE_BUTTON_LEFT) return;
  actions.push_back(call(action::begin_shape, picture_cursor(), select_how()));
  const bool twice = now - last_press_time_ < kDoubleClickSeconds &&
                     glm::distance(cursor_, last_press_) < kDoubleClickPixels;
  if (twice) actions.push_back(unless_with_tool(call(action::pick_pivot, picture_cursor())));
  last_press_time_ = twice ? -1e9 : now;
  last_press_ = cursor_;
}

void Input::cursor(glm::dvec2 pixel, Navigation navigation, Actions& actions) {
  const glm::dvec2 by = pixel - cursor_;
  cursor_ = pixel;
  if (!dragged_ || by == glm::dvec2(0)) return;
  const auto motion = is_pan()                             ? action::pan
                      : navigation == Navigation::fly      ? action::look
                      : dragged_ == GLFW_MOUSE_BUTTON_LEFT ? action::orbit
                                                           : action::pan;
  const auto turns = navigation == Navigation::fly ? action::look : action::orbit;
  actions.push_back([=, drag = *dragged_, at = picture_cursor()](Viewer& v, Host&) {
    if (!v.selecting.tool || drag == GLFW_MOUSE_BUTTON_MIDDLE) return motion(v, by);
    // With a tool the left button draws, and the right button turns the view.
    drag == GLFW_MOUSE_BUTTON_LEFT ? action::extend_shape(v, at) : turns(v, by);
  });
}

SelectHow Input::select_how() const {
  const auto is_held = [&](int left, int right) {
    return held_.contains(left) || held_.contains(right);
  };
  const bool shift = is_held(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT);
  const bool control = is_held(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL);
  return shift && control ? SelectHow::common
         : shift          ? SelectHow::add
         : control        ? SelectHow::take_away
                          : SelectHow::replace;
}

void Input::wheel(double notches, int mods, bool captured, Actions& actions) {
  if (captured || notches == 0) return;
  const auto motion = (mods & GLFW_MOD_SHIFT) != 0     ? action::change_fov
                      : (mods & GLFW_MOD_CONTROL) != 0 ? action::roll
                                                       : action::turn_wheel;
  actions.push_back(call(motion, notches));
}

void Input::release_all(Actions& actions) {
  const std::set<int> held = held_;
  for (const int key : held) this->key(key, false, false, 0, false, actions);
  dragged_.reset();
  mods_ = 0;
}

bool Input::is_pan() const { return dragged_ == GLFW_MOUSE_BUTTON_MIDDLE; }

bool Input::flies() const {
  const auto is_held = [&](const FlyKey& row) { return held_.contains(row.key); };
  return (mods_ & GLFW_MOD_CONTROL) == 0 && std::ranges::any_of(fly_keys(), is_held);
}

void Input::tick(Actions& actions) const {
  if (!flies()) return;
  glm::dvec3 direction(0);
  for (const FlyKey& row : fly_keys())
    if (held_.count(row.key) > 0) direction += row.direction;
  const double factor =
      ((mods_ & GLFW_MOD_SHIFT) != 0 ? kFast : 1) * ((mods_ & GLFW_MOD_ALT) != 0 ? kSlow : 1);
  if (direction != glm::dvec3(0))
    actions.push_back(unless_typing(call(action::fly, direction, factor)));
}

}  // namespace qs
