// SPDX-License-Identifier: MIT
#include "app/viewer/window/window.h"

#include <algorithm>
#include <cctype>
#include <cfloat>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <mutex>

#include <epoxy/gl.h>
// After epoxy, which declares GL's functions.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "app/viewer/commands/keys.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/crop_actions.h"
#include "app/viewer/state/layout.h"
#include "app/viewer/state/zoom_actions.h"
#include "base/assets.h"
#include "base/fail.h"

namespace qs {
namespace {

Window* self(GLFWwindow* window) { return static_cast<Window*>(glfwGetWindowUserPointer(window)); }

/// Names of the buttons in scripts; index = GLFW_MOUSE_BUTTON_*.
constexpr const char* kButtons[] = {"left", "right", "middle"};

// Guards the flag that GLFW can be woken.
std::mutex wake_mutex;
bool can_wake = false;

void allow_waking(bool allowed) {
  const std::lock_guard lock(wake_mutex);
  can_wake = allowed;
}

std::string glfw_reason() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text == nullptr ? "unknown reason" : text;
}

// The area for windows on the first screen, in screen units.
glm::ivec2 work_area() {
  glm::ivec2 at(0), size(0);
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  if (monitor != nullptr) glfwGetMonitorWorkarea(monitor, &at.x, &at.y, &size.x, &size.y);
  return size.x > 0 && size.y > 0 ? size : glm::ivec2(1600, 900);
}

glm::ivec2 screen_size() {
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor == nullptr ? nullptr : glfwGetVideoMode(monitor);
  return mode == nullptr ? work_area() : glm::ivec2(mode->width, mode->height);
}

// Dear ImGui 1.92 and later do so themselves.
void renew_font_texture() {
#if IMGUI_VERSION_NUM < 19200
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
#endif
}

// GLFW 3.4 tries Wayland before X11. Without a folder for its socket, Wayland's library would only
// print a message of its own.
void choose_platform() {
#ifdef GLFW_PLATFORM
  if (std::getenv("XDG_RUNTIME_DIR") == nullptr) glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
}

// True if the environment names a display. Otherwise GLFW would load all its platforms without
// success.
bool may_have_a_display() {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "XDG_RUNTIME_DIR"}) {
    if (std::getenv(name) != nullptr) return true;
  }
  return false;
}

}  // namespace

Window::Window(glm::ivec2 size, glm::ivec2 screen) {
  choose_platform();
  if (!may_have_a_display() || glfwInit() != GLFW_TRUE) {
    fail(ErrorKind::device,
         "view: there is no display ({}): 'quadsplat render' draws into files instead",
         may_have_a_display() ? glfw_reason() : "DISPLAY is not set");
  }
  screen_ = screen == glm::ivec2(0) ? screen_size() : screen;
  open_window(size == glm::ivec2(0) ? first_window_size(work_area()) : size);
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui_ImplGlfw_InitForOpenGL(window_, false);
  ImGui_ImplOpenGL3_Init("#version 330 core");
#if IMGUI_VERSION_NUM < 18700
  // Enter activates, as in later versions; the space bar stays a shortcut.
  ImGui::GetIO().KeyMap[ImGuiKey_Space] = GLFW_KEY_ENTER;
#endif
  set_scale(screen_scale());
  allow_waking(true);
}

void Window::open_window(glm::ivec2 size) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  window_ = glfwCreateWindow(size.x, size.y, "quadsplat", nullptr, nullptr);
  if (window_ == nullptr) {
    const std::string reason = glfw_reason();
    glfwTerminate();
    fail(ErrorKind::device,
         "view: no window with OpenGL 3.3 can be opened ({}): 'quadsplat render' draws into files "
         "instead",
         reason);
  }
  glfwMakeContextCurrent(window_);
  glfwSetWindowUserPointer(window_, this);
  const glm::ivec2 least = glm::min(size, kLeastWindow);
  glfwSetWindowSizeLimits(window_, least.x, least.y, GLFW_DONT_CARE, GLFW_DONT_CARE);
  set_callbacks();
}

Window::~Window() {
  allow_waking(false);
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void Window::note_event() { last_event_ = glfwGetTime(); }

void Window::set_callbacks() {
  glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int scancode, int action, int mods) {
    ImGui_ImplGlfw_KeyCallback(window, key, scancode, action, mods);
    self(window)->on_key(key, action, mods);
  });
  glfwSetCharCallback(window_, ImGui_ImplGlfw_CharCallback);
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int mods) {
    ImGui_ImplGlfw_MouseButtonCallback(window, button, action, mods);
    self(window)->on_button(button, action, mods);
  });
  glfwSetCursorPosCallback(
      window_, [](GLFWwindow* window, double x, double y) { self(window)->on_cursor(x, y); });
  glfwSetScrollCallback(window_, [](GLFWwindow* window, double x, double y) {
    ImGui_ImplGlfw_ScrollCallback(window, x, y);
    self(window)->on_scroll(x, y);
  });
  glfwSetWindowFocusCallback(window_, [](GLFWwindow* window, int focused) {
    ImGui_ImplGlfw_WindowFocusCallback(window, focused);
    Window& me = *self(window);
    me.note_event();
    if (focused == GLFW_FALSE && me.actions_ != nullptr) me.input_.release_all(*me.actions_);
  });
  glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** paths) {
    Window& me = *self(window);
    me.note_event();
    if (me.actions_ == nullptr) return;
    for (int i = 0; i < count; ++i)
      me.actions_->push_back(call(action::open, std::filesystem::path(paths[i])));
  });
  glfwSetWindowRefreshCallback(window_, [](GLFWwindow* window) { self(window)->note_event(); });
  // Nothing is under the mouse any more.
  glfwSetCursorEnterCallback(window_, [](GLFWwindow* window, int) { self(window)->note_event(); });
}

WindowMetrics Window::metrics() const {
  return {size(), letter_, letter_ + 2 * ImGui::GetStyle().FramePadding.y};
}

float Window::pixels_per_unit() const {
  return static_cast<float>(framebuffer().y) / static_cast<float>(std::max(size().y, 1));
}

void Window::set_scale(float scale, bool is_light) {
  const float letter = std::round(kFontSize * scale);
  const float pixels = std::round(letter * std::max(pixels_per_unit(), 1.0f));
  if (letter == letter_ && pixels == letter_pixels_ && is_light == palette::is_light) return;
  const bool had_fonts = letter_ > 0;
  letter_ = letter;
  letter_pixels_ = pixels;
  ImGui::GetIO().Fonts->Clear();
  add_fonts(pixels);
  ImGui::GetIO().FontGlobalScale = letter / pixels;
  if (had_fonts) renew_font_texture();  // else the first frame makes it
  apply_style(scale, is_light);
  note_event();
}

void Window::add_fonts(float pixels) {
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  glyphs_ = glyph_ranges(letters_);
  if (const auto file = find_font()) {
    fonts.AddFontFromFileTTF(file->c_str(), pixels, nullptr, glyphs_.Data);
  } else {
    fonts.AddFontDefault();
  }
  if (letters_.empty()) return;
  const std::optional<SystemFont> other = system_font(letters_);
  std::error_code error;
  if (!other || !std::filesystem::is_regular_file(other->file, error)) return;
  ImFontConfig config;
  config.MergeMode = true;
  config.FontNo = other->index;
  fonts.AddFontFromFileTTF(other->file.c_str(), pixels, &config, glyphs_.Data);
}

void Window::show_names(const Viewer& viewer, const FileChooser& chooser) {
  if (!add_shown_letters(letters_, viewer, chooser)) return;
  letter_pixels_ = 0;
  set_scale(interface_scale(viewer), viewer.light_theme);
}

// While a drag turns the camera that flies, the cursor does not stop at the screen's edge, and the
// wheel reaches the window.
void Window::lock_cursor() {
  const bool locks = input_.looks_around(navigation_) && !scripted_cursor_;
  if (locks == cursor_is_locked_) return;
  cursor_is_locked_ = locks;
  glfwSetInputMode(window_, GLFW_CURSOR, locks ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
  if (locks) return;
  double x = 0, y = 0;  // the place before, without an event of its own
  glfwGetCursorPos(window_, &x, &y);
  on_cursor(x, y);
}

void Window::on_key(int key, int action, int mods) {
  note_event();
  if (action == GLFW_PRESS) pressed_.push_back(key);
  if (actions_ == nullptr) return;
  input_.key(key, action != GLFW_RELEASE, action == GLFW_REPEAT, mods, ImGui::GetIO().WantTextInput,
             *actions_);
}

void Window::on_button(int button, int action, int) {
  note_event();
  if (actions_ == nullptr) return;
  input_.button(button, action == GLFW_PRESS, ImGui::GetIO().WantCaptureMouse, last_event_,
                *actions_);
}

void Window::on_cursor(double x, double y) {
  note_event();
  if (actions_ == nullptr || scripted_cursor_) return;
  const glm::dvec2 pixels_per_unit =
      glm::dvec2(framebuffer()) / glm::max(glm::dvec2(1), glm::dvec2(size()));
  input_.cursor(glm::dvec2(x, y) * pixels_per_unit, navigation_, *actions_);
}

void Window::on_scroll(double, double y) {
  note_event();
  if (actions_ == nullptr) return;
  int mods = 0;
  const auto held = [&](int left, int right) {
    return glfwGetKey(window_, left) == GLFW_PRESS || glfwGetKey(window_, right) == GLFW_PRESS;
  };
  if (held(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT)) mods |= GLFW_MOD_SHIFT;
  if (held(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL)) mods |= GLFW_MOD_CONTROL;
  input_.wheel(y, mods, ImGui::GetIO().WantCaptureMouse, *actions_);
}

void Window::poll(double seconds, Navigation navigation, Actions& actions) {
  actions_ = &actions;
  navigation_ = navigation;
  if (seconds > 0) {
    glfwWaitEventsTimeout(seconds);
  } else {
    glfwPollEvents();
  }
  lock_cursor();
  actions_ = nullptr;
}

void Window::read_gamepad(double seconds, Actions& actions) {
  GLFWgamepadstate pad;
  int id = GLFW_JOYSTICK_1;
  while (id <= GLFW_JOYSTICK_LAST && glfwGetGamepadState(id, &pad) != GLFW_TRUE) ++id;
  const bool acts = id <= GLFW_JOYSTICK_LAST && glfwGetWindowAttrib(window_, GLFW_FOCUSED) != 0;
  input_.gamepad(acts ? &pad : nullptr, seconds, actions);
}

void Window::wake() {
  const std::lock_guard lock(wake_mutex);
  if (can_wake) glfwPostEmptyEvent();
}

void Window::begin_ui() {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  if (scripted_cursor_) {
    const glm::dvec2 units =
        input_.cursor() * (glm::dvec2(size()) / glm::max(glm::dvec2(1), glm::dvec2(framebuffer())));
    put_scripted_cursor(glm::vec2(units));
  }
  press_briefly();
  if (cursor_is_locked_) ImGui::GetIO().MousePos = {-FLT_MAX, -FLT_MAX};
  ImGui::NewFrame();
}

#if IMGUI_VERSION_NUM >= 18700
// ImGui queues events, and shows every press to at least one frame.
void Window::put_scripted_cursor(glm::vec2 units) {
  ImGui::GetIO().AddMousePosEvent(units.x, units.y);
}
void Window::press_briefly() { pressed_.clear(); }
void Window::release_brief_keys() {}
#else
void Window::put_scripted_cursor(glm::vec2 units) {
  ImGuiIO& io = ImGui::GetIO();
  io.MousePos = {units.x, units.y};
  for (std::size_t i = 0; i < scripted_buttons_.size(); ++i)
    io.MouseDown[i] = io.MouseDown[i] || scripted_buttons_[i];
}

// ImGui sees the keys that are down when a frame begins. A key that was pressed and released since
// the last frame is down in this frame.
void Window::press_briefly() {
  ImGuiIO& io = ImGui::GetIO();
  for (const int key : pressed_) {
    if (key < 0 || io.KeysDown[key]) continue;
    io.KeysDown[key] = true;
    brief_.push_back(key);
  }
  pressed_.clear();
}

void Window::release_brief_keys() {
  for (const int key : brief_) ImGui::GetIO().KeysDown[key] = false;
  brief_.clear();
}
#endif

void Window::end_ui() {
  release_brief_keys();
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Window::swap() { glfwSwapBuffers(window_); }

void Window::play(const ScriptStep& step, double now, Actions& actions) {
  note_event();
  const auto number = [&](std::size_t i) { return std::stod(step.words[i]); };
  const auto use_shortcut = [&](const KeyPress& key, bool down) {
    input_.key(key.key, down, false, key.mods, ImGui::GetIO().WantTextInput, actions);
  };
  const auto press = [&](const KeyPress& key, bool down) {
    ImGui_ImplGlfw_KeyCallback(window_, key.key, 0, down ? GLFW_PRESS : GLFW_RELEASE, key.mods);
    if (down) pressed_.push_back(key.key);
    use_shortcut(key, down);
  };
  const auto click = [&](int button, bool down) {
    scripted_buttons_[static_cast<std::size_t>(button)] = down;
    ImGui_ImplGlfw_MouseButtonCallback(window_, button, down ? GLFW_PRESS : GLFW_RELEASE, 0);
    input_.button(button, down, ImGui::GetIO().WantCaptureMouse, now, actions);
  };
  if (step.command == "key" || step.command == "keypad") {
    const KeyPress key = step.command == "key"
                             ? parse_key(step.words[0])
                             : KeyPress{GLFW_KEY_KP_0 + static_cast<int>(number(0)), 0};
    press(key, true);
    press(key, false);
  } else if (step.command == "press" || step.command == "release") {
    const bool down = step.command == "press";
    const auto button = std::ranges::find(kButtons, step.words[0]);
    if (button != std::end(kButtons)) {
      click(static_cast<int>(button - std::begin(kButtons)), down);
    } else {
      press(parse_key(step.words[0]), down);
    }
  } else if (step.command == "move") {
    scripted_cursor_ = true;
    input_.cursor({number(0), number(1)}, navigation_, actions);
  } else if (step.command == "click" || step.command == "doubleclick") {
    for (int i = 0; i < (step.command == "click" ? 1 : 2); ++i) {
      click(GLFW_MOUSE_BUTTON_LEFT, true);
      click(GLFW_MOUSE_BUTTON_LEFT, false);
    }
  } else if (step.command == "nudge") {
    scripted_cursor_ = true;
    input_.cursor(input_.cursor() + glm::dvec2(number(0), number(1)), navigation_, actions);
  } else if (step.command == "wheel") {
    const int mods = step.words.size() > 1 ? parse_key(step.words[1] + "+A").mods : 0;
    input_.wheel(number(0), mods, false, actions);
  } else if (step.command == "type") {
    // Types like a keyboard: a key with its character. Text fields read the character alone.
    for (const char c : step.words[0]) {
      const auto letter = static_cast<unsigned char>(c);
      const bool has_key = std::isalnum(letter) != 0 || c == '/' || c == '.' || c == '-';
      const KeyPress key{std::toupper(letter), 0};
      if (has_key) use_shortcut(key, true);
      ImGui::GetIO().AddInputCharacter(letter);
      if (has_key) use_shortcut(key, false);
    }
  } else if (step.command == "drop") {
    actions.push_back(call(action::open, std::filesystem::path(step.words[0])));
  } else if (step.command == "crop") {
    actions.push_back(call(action::choose_crop, step.words[0]));
  } else if (step.command == "zoom") {
    actions.push_back(call(action::choose_zoom, step.words[0]));
  } else if (step.command == "paste") {
    set_clipboard(step.words[0]);
  }
}

bool Window::close_requested() {
  const bool asked = glfwWindowShouldClose(window_) == GLFW_TRUE;
  glfwSetWindowShouldClose(window_, GLFW_FALSE);
  return asked;
}

void Window::set_title(const std::string& title) {
  if (title == title_) return;
  title_ = title;
  glfwSetWindowTitle(window_, title.c_str());
}

void Window::set_vsync(bool on) { glfwSwapInterval(on ? 1 : 0); }

void Window::toggle_fullscreen() {
  if (glfwGetWindowMonitor(window_) != nullptr) {
    glfwSetWindowMonitor(window_, nullptr, windowed_position_.x, windowed_position_.y,
                         windowed_size_.x, windowed_size_.y, GLFW_DONT_CARE);
    return;
  }
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor == nullptr ? nullptr : glfwGetVideoMode(monitor);
  if (mode == nullptr) return;
  glfwGetWindowPos(window_, &windowed_position_.x, &windowed_position_.y);
  windowed_size_ = size();
  glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

void Window::set_clipboard(const std::string& text) {
  glfwSetClipboardString(window_, text.c_str());
}

std::string Window::clipboard() const {
  const char* text = glfwGetClipboardString(window_);
  return text == nullptr ? "" : text;
}

glm::ivec2 Window::framebuffer() const {
  glm::ivec2 pixels(0);
  glfwGetFramebufferSize(window_, &pixels.x, &pixels.y);
  return pixels;
}

glm::ivec2 Window::size() const {
  glm::ivec2 units(0);
  glfwGetWindowSize(window_, &units.x, &units.y);
  return units;
}

glm::ivec2 Window::windowed_size() const {
  return glfwGetWindowMonitor(window_) != nullptr ? windowed_size_ : size();
}

// On some systems a screen unit already has as many pixels as the system's scale demands.
float Window::screen_scale() const {
  float x = 1, y = 1;
  glfwGetWindowContentScale(window_, &x, &y);
  return guessed_scale(std::min(x, y) / std::max(pixels_per_unit(), 1.0f), screen_);
}

}  // namespace qs
