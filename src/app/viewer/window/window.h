// SPDX-License-Identifier: MIT
//
// The window: GLFW, its OpenGL context, Dear ImGui. Everything that people do in it arrives as
// actions. Sizes of pictures are pixels of the framebuffer, also on displays with several pixels to
// a unit of the screen.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>

#include "app/viewer/window/input.h"
#include "app/viewer/window/input_script.h"

struct GLFWwindow;

namespace qs {

class Window {
 public:
  /// `size` in screen units. Throws Error(device) with one sentence when there is no display or no
  /// OpenGL 3.3.
  explicit Window(glm::ivec2 size);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Handles what has happened; waits up to `seconds` for something to happen, 0 = does not wait.
  void poll(double seconds, Navigation navigation, Actions& actions);
  static void wake();  ///< ends poll()'s wait, from any thread

  void begin_ui();  ///< between these, panels draw
  void end_ui();
  void swap();

  /// Does what one step of an input script says; false when it is not one of the window's.
  bool play(const ScriptStep& step, double now, Actions& actions);

  bool close_requested() const;
  void set_title(const std::string& title);
  void set_vsync(bool on);
  void toggle_fullscreen();
  void set_clipboard(const std::string& text);
  std::string clipboard() const;

  glm::ivec2 framebuffer() const;
  glm::ivec2 size() const;           ///< screen units
  glm::ivec2 windowed_size() const;  ///< the same, outside of full screen
  float scale() const;               ///< of letters and lines, times their usual size
  Input& input() { return input_; }
  GLFWwindow* handle() const { return window_; }
  double seconds_since_event() const;

 private:
  void set_callbacks();
  void add_fonts();
  void on_key(int key, int action, int mods);
  void on_button(int button, int action, int mods);
  void on_cursor(double x, double y);
  void on_scroll(double x, double y);

  GLFWwindow* window_ = nullptr;
  Input input_;
  Actions* actions_ = nullptr;  // of the poll() that runs
  Navigation navigation_ = Navigation::orbit;
  glm::ivec2 windowed_position_{0}, windowed_size_{0};
  bool scripted_cursor_ = false;            // a script owns the cursor
  std::array<bool, 3> scripted_buttons_{};  // that it keeps down
  std::string script_clipboard_;
  double last_event_ = 0;
};

}  // namespace qs
