// SPDX-License-Identifier: MIT
//
// The messages of the page, one JSON object each:
//   {"type":"hello", "token":"...", "width":1280, "height":720}   the first message
//   {"type":"resize", "width":1280, "height":720}
//   {"type":"key", "code":"KeyW", "down":true, "repeat":false, "shift":false, "ctrl":false,
//   "alt":false}
//   {"type":"button", "button":0, "down":true, "x":10, "y":20}    0 left, 1 right, 2 middle
//   {"type":"cursor", "x":10, "y":20}                             pixels of the picture
//   {"type":"wheel", "notches":1, "shift":false, "ctrl":false}
//   {"type":"command", "command":"Frame the scene"}               KeyCommand::help
//   {"type":"scene", "scene":0}
//   {"type":"set", "control":"splat scale", "value":1.5, "index":0}   a Control; index of an item
//   {"type":"handle", "face":3, "x":10, "y":20}                   drags a face of the crop box
//   {"type":"view", "scene":0, "camera":"{...}", "mode":"exact"}  a view that the page has kept
//   {"type":"panels", "open":["Inspector: boxes of a Gaussian"]}  the panels that are open, and
//                                                                 all others are closed
//   {"type":"stop"}                                               the visitor's film or zoom
//   {"type":"received", "count":7, "held":12.5}                   binary messages so far, and
//                                                                 the age of the last in ms
//   {"type":"video", "decodes":true}                              the page decodes VP9, from the
//                                                                 next key picture on
//   {"type":"file", "name":"a.edits.json", "text":"{...}"}        opens edits or measures
//   {"type":"blur"}                                               the page lost the keyboard
// Every message may have "input", the number of the user's input; pictures name the last input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <glm/vec2.hpp>

namespace qs {

/// The longest side of a picture.
inline constexpr int kMostSide = 4096;
/// The longest camera of a view, and the longest text of a file, bytes.
inline constexpr std::size_t kMostCamera = 4096, kMostFile = std::size_t{1} << 20;

namespace message {

struct Hello {
  std::string token;
  glm::ivec2 size{1};  ///< of the picture, 1 to kMostSide
};
struct Resize {
  glm::ivec2 size{1};
};
struct Key {
  int key = 0;  ///< GLFW_KEY_*; 0: not a key of any command
  bool down = false, repeat = false;
  int mods = 0;  ///< GLFW_MOD_SHIFT, _CONTROL, _ALT
};
struct Button {
  int button = 0;  ///< GLFW_MOUSE_BUTTON_LEFT, _RIGHT or _MIDDLE
  bool down = false;
  glm::dvec2 at{0.0};
};
struct Cursor {
  glm::dvec2 at{0.0};
};
struct Wheel {
  double notches = 0;
  int mods = 0;
};
struct Command {
  std::string help;
};
struct ShowScene {
  std::size_t scene = 0;
};
struct SetControl {
  std::string control;  ///< Control::name
  double value = 0;     ///< finite
  std::size_t index = 0;
};
struct DragHandle {
  int face = 0;  ///< 0 to 5
  glm::dvec2 at{0.0};
};
struct ShowView {
  std::size_t scene = 0;
  std::string camera;  ///< for parse_camera(), not checked
  std::string mode;
};
struct ShowPanels {
  std::vector<std::string> open;  ///< KeyCommand::help
};
struct Stop {};
struct Received {
  std::uint32_t count = 0;
  double held = 0;  ///< milliseconds, 0 to 10,000
};
struct Video {
  bool decodes = false;
};
struct OpenFile {
  std::string name;  ///< without folders
  std::string text;  ///< not checked
};
struct Blur {};

}  // namespace message

struct ClientMessage {
  std::uint32_t input = 0;  ///< 0: not an input of the user
  std::variant<message::Hello, message::Resize, message::Key, message::Button, message::Cursor,
               message::Wheel, message::Command, message::ShowScene, message::SetControl,
               message::DragHandle, message::ShowView, message::ShowPanels, message::Stop,
               message::Received, message::Video, message::OpenFile, message::Blur>
      body;
};

/// The GLFW_KEY_* of a KeyboardEvent.code such as "KeyW"; 0 if no command can have this key.
int key_of_code(std::string_view code);

/// Unset for a text that is not one of these messages: no JSON, an unknown type, a missing value, a
/// number that is not finite or out of its range. Does not throw.
std::optional<ClientMessage> parse_message(std::string_view text);

}  // namespace qs
