// SPDX-License-Identifier: MIT
//
// The window: GLFW, its OpenGL context, Dear ImGui. User input arrives as actions. Sizes of
// pictures are pixels of the framebuffer, also on displays with several pixels per screen unit.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/viewer/commands/input.h"
#include "app/viewer/state/layout.h"
#include "app/viewer/window/input_script.h"
#include "app/viewer/window/letters.h"
#include "base/not_copied.h"

struct GLFWwindow;

namespace qs {

class Window : NotCopied {
 public:
  /// `size` in screen units; 0: first_window_size() of the screen. `screen`: the size of the screen
  /// for which the scale is guessed; 0: its own. Throws Error(device) without a display or OpenGL
  /// 3.3.
  explicit Window(glm::ivec2 size, glm::ivec2 screen = glm::ivec2(0));
  ~Window();

  /// Handles events; waits up to `seconds` for the first event.
  void poll(double seconds, Navigation navigation, Actions& actions);
  /// The first gamepad acts while the window has the keyboard. `seconds` since the last call.
  void read_gamepad(double seconds, Actions& actions);
  static void wake();  ///< ends poll()'s wait, from any thread, also without a window

  void begin_ui();  ///< panels draw between begin_ui() and end_ui()
  void end_ui();
  void swap();

  /// Carries out a command of an input script that ScriptPlayer::next() returned.
  void play(const ScriptStep& step, double now, Actions& actions);

  bool close_requested();  ///< since the last call
  void set_title(const std::string& title);
  void set_vsync(bool on);
  void toggle_fullscreen();
  void set_clipboard(const std::string& text);
  std::string clipboard() const;

  glm::ivec2 framebuffer() const;
  glm::ivec2 size() const;           ///< screen units
  glm::ivec2 windowed_size() const;  ///< size() outside of full screen
  float screen_scale() const;        ///< guessed_scale() of the screen
  /// Makes letters and lines this factor larger. Letters are rasterised again, so they stay sharp.
  /// Called between end_ui() and begin_ui(). `is_light`: the theme.
  void set_scale(float scale, bool is_light = false);
  /// Makes the letters of these names drawable. Called between end_ui() and begin_ui().
  void show_names(const Viewer& viewer, const FileChooser& chooser);
  WindowMetrics metrics() const;  ///< as set_scale() made them
  Input& input() { return input_; }
  GLFWwindow* handle() const { return window_; }
  double last_event() const { return last_event_; }  ///< glfwGetTime() of the last input

 private:
  void note_event();
  void set_callbacks();
  void open_window(glm::ivec2 size);
  void add_fonts(float pixels);
  void lock_cursor();
  float pixels_per_unit() const;
  void on_key(int key, int action, int mods);
  void put_scripted_cursor(glm::vec2 units);
  void press_briefly();
  void release_brief_keys();
  void on_button(int button, int action, int mods);
  void on_cursor(double x, double y);
  void on_scroll(double x, double y);

  GLFWwindow* window_ = nullptr;
  Input input_;
  Actions* actions_ = nullptr;  // the list that the current poll() fills
  Navigation navigation_ = Navigation::orbit;
  glm::ivec2 windowed_position_{0}, windowed_size_{0};
  bool scripted_cursor_ = false;            // a script moves the cursor
  std::array<bool, 3> scripted_buttons_{};  // buttons that the script holds
  std::string title_;
  glm::ivec2 screen_{0};  // for which the scale is guessed
  // font size in screen units, and the pixel size of its atlas
  float letter_ = 0, letter_pixels_ = 0;
  Letters letters_;                // of names, beside the usual ones
  ImVector<ImWchar> glyphs_;       // of the atlas
  bool cursor_is_locked_ = false;  // and hidden
  // keys pressed since the last frame, and keys already released
  std::vector<int> pressed_, brief_;
  double last_event_ = 0;
};

}  // namespace qs
