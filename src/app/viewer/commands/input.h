// SPDX-License-Identifier: MIT
//
// Turns keys, buttons, the wheel and the gamepad into actions, without a window: the window's
// callbacks and the input scripts call the same functions. `captured`: a panel uses the input.
#pragma once

#include <optional>
#include <set>

#include "app/viewer/state/action.h"
#include "raster/select/edit_step.h"

struct GLFWgamepadstate;

namespace qs {

/// The motion of the camera by the sticks and triggers of a gamepad; 0 while they rest.
struct PadMotion {
  glm::dvec3 direction{0.0};  ///< right, down, forward, times the factor, as flight takes it
  glm::dvec2 turn{0.0};       ///< right, down, radians per second
};
PadMotion pad_motion(const GLFWgamepadstate& pad);

class Input {
 public:
  /// `down`: pressed or repeated.
  void key(int key, bool down, bool repeat, int mods, bool captured, Actions& actions);
  void button(int button, bool down, bool captured, double now, Actions& actions);
  /// `pixel`: of the window.
  void cursor(glm::dvec2 pixel, Navigation navigation, Actions& actions);
  void wheel(double notches, int mods, bool captured, Actions& actions);

  /// The gamepad, `seconds` after the last call; null: there is none.
  void gamepad(const GLFWgamepadstate* pad, double seconds, Actions& actions);

  /// Releases everything, because the window lost the keyboard.
  void release_all(Actions& actions);

  /// Flies in the direction of the held keys.
  void tick(Actions& actions) const;

  /// True while a drag turns a camera that flies.
  bool looks_around(Navigation navigation) const {
    return navigation == Navigation::fly && dragged_ && !is_pan();
  }

  /// A gamepad wakes nobody, so the loop looks at it.
  bool busy() const { return dragged_.has_value() || flies() || has_gamepad_; }

  /// The upper left corner of the picture in the window, pixels. Actions get positions in the
  /// picture.
  void set_picture_origin(glm::dvec2 pixel) { origin_ = pixel; }

  glm::dvec2 cursor() const { return cursor_; }  ///< pixels of the window
  glm::dvec2 picture_cursor() const { return cursor_ - origin_; }

 private:
  bool flies() const;
  bool is_pan() const;
  SelectHow select_how() const;  // by the modifiers that are held

  std::set<int> held_;  // keys; buttons of the gamepad as -1 - GLFW_GAMEPAD_BUTTON_*
  int mods_ = 0;
  bool has_gamepad_ = false;
  std::optional<int> dragged_;  // button
  glm::dvec2 cursor_{0.0}, origin_{0.0}, last_press_{-1e9};
  double last_press_time_ = -1e9;
};

}  // namespace qs
