// SPDX-License-Identifier: MIT
#include "app/serve/message.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <nlohmann/json.hpp>

namespace qs {
namespace {

using Json = nlohmann::json;

constexpr double kMostPixels = 1e5, kMostNotches = 100, kMostHeld = 1e4, kMostValue = 1e9;
constexpr std::uint32_t kMostScene = 100'000;
constexpr std::size_t kMostText = 200, kMostPanels = 100;

// Reads the values of an object. A missing or unfit value makes `sound` false.
struct MessageReader {
  const Json& object;
  bool sound = true;

  const Json& value(const char* name) {
    static const Json kNothing;
    const auto found = object.find(name);
    if (found != object.end()) return *found;
    sound = false;
    return kNothing;
  }
  double real(const char* name, double most) {
    const Json& found = value(name);
    const double number = found.is_number() ? found.get<double>() : NAN;
    if (std::abs(number) <= most) return number;  // false for NaN
    sound = false;
    return 0;
  }
  std::uint32_t whole(const char* name, std::uint32_t least, std::uint32_t most) {
    const Json& found = value(name);
    if (found.is_number_unsigned()) {
      const auto number = found.get<std::uint64_t>();
      if (number >= least && number <= most) return static_cast<std::uint32_t>(number);
    }
    sound = false;
    return least;
  }
  std::string text(const char* name, std::size_t most = kMostText) {
    return text_of(value(name), most);
  }
  std::string text_of(const Json& found, std::size_t most) {
    if (found.is_string() && found.get_ref<const std::string&>().size() <= most)
      return found.get<std::string>();
    sound = false;
    return {};
  }
  std::vector<std::string> texts(const char* name, std::size_t most) {
    const Json& found = value(name);
    sound = sound && found.is_array() && found.size() <= most;
    std::vector<std::string> all;
    for (std::size_t i = 0; sound && i < found.size(); ++i)
      all.push_back(text_of(found[i], kMostText));
    return all;
  }
  bool flag(const char* name) {
    const Json& found = value(name);
    sound = sound && found.is_boolean();
    return found.is_boolean() && found.get<bool>();
  }
  // A flag that may be missing.
  bool set(const char* name) { return object.contains(name) && flag(name); }

  double held() {
    const double milliseconds = object.contains("held") ? real("held", kMostHeld) : 0;
    sound = sound && milliseconds >= 0;
    return milliseconds;
  }
  int mods() {
    return (set("shift") ? GLFW_MOD_SHIFT : 0) | (set("ctrl") ? GLFW_MOD_CONTROL : 0) |
           (set("alt") ? GLFW_MOD_ALT : 0);
  }
  glm::ivec2 size() {
    const std::uint32_t width = whole("width", 1, kMostSide);
    return {static_cast<int>(width), static_cast<int>(whole("height", 1, kMostSide))};
  }
  glm::dvec2 place() {
    const double x = real("x", kMostPixels);
    return {x, real("y", kMostPixels)};
  }
};

// A message of an unknown type is not sound.
decltype(ClientMessage::body) body_of(std::string_view type, MessageReader& r) {
  if (type == "hello") return message::Hello{r.text("token"), r.size()};
  if (type == "resize") return message::Resize{r.size()};
  if (type == "key")
    return message::Key{key_of_code(r.text("code")), r.flag("down"), r.set("repeat"), r.mods()};
  if (type == "button")
    return message::Button{static_cast<int>(r.whole("button", 0, 2)), r.flag("down"), r.place()};
  if (type == "cursor") return message::Cursor{r.place()};
  if (type == "wheel") return message::Wheel{r.real("notches", kMostNotches), r.mods()};
  if (type == "command") return message::Command{r.text("command")};
  if (type == "scene") return message::ShowScene{r.whole("scene", 0, kMostScene)};
  if (type == "set") {
    const std::uint32_t index = r.object.contains("index") ? r.whole("index", 0, ~0u) : 0;
    return message::SetControl{r.text("control"), r.real("value", kMostValue), index};
  }
  if (type == "handle")
    return message::DragHandle{static_cast<int>(r.whole("face", 0, 5)), r.place()};
  if (type == "view") {
    const std::size_t scene = r.whole("scene", 0, kMostScene);
    return message::ShowView{scene, r.text("camera", kMostCamera), r.text("mode")};
  }
  if (type == "panels") return message::ShowPanels{r.texts("open", kMostPanels)};
  if (type == "stop") return message::Stop{};
  if (type == "received") return message::Received{r.whole("count", 0, ~0u), r.held()};
  if (type == "video") return message::Video{r.flag("decodes")};
  if (type == "file") {
    message::OpenFile file{r.text("name"), r.text("text", kMostFile)};
    r.sound = r.sound && file.name.find('/') == std::string::npos;
    return file;
  }
  r.sound = r.sound && type == "blur";
  return message::Blur{};
}

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
    KeyCode{"Delete", GLFW_KEY_DELETE},
    KeyCode{"Escape", GLFW_KEY_ESCAPE},
    KeyCode{"Comma", GLFW_KEY_COMMA},
    KeyCode{"Period", GLFW_KEY_PERIOD},
    KeyCode{"Enter", GLFW_KEY_ENTER},
    KeyCode{"ArrowLeft", GLFW_KEY_LEFT},
    KeyCode{"ArrowRight", GLFW_KEY_RIGHT},
    KeyCode{"ArrowUp", GLFW_KEY_UP},
    KeyCode{"ArrowDown", GLFW_KEY_DOWN},
    KeyCode{"ShiftLeft", GLFW_KEY_LEFT_SHIFT},
    KeyCode{"ShiftRight", GLFW_KEY_RIGHT_SHIFT},
    KeyCode{"ControlLeft", GLFW_KEY_LEFT_CONTROL},
    KeyCode{"ControlRight", GLFW_KEY_RIGHT_CONTROL},
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
  const auto found = std::ranges::find(kKeyCodes, code, &KeyCode::code);
  return found == kKeyCodes.end() ? 0 : found->key;
}

std::optional<ClientMessage> parse_message(std::string_view text) {
  const Json object = Json::parse(text, nullptr, false);
  if (!object.is_object()) return {};
  MessageReader reader{object};
  ClientMessage parsed;
  if (object.contains("input")) parsed.input = reader.whole("input", 0, ~0u);
  parsed.body = body_of(reader.text("type"), reader);
  return reader.sound ? std::optional(parsed) : std::nullopt;
}

}  // namespace qs
