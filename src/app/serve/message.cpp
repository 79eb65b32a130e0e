// SPDX-License-Identifier: MIT
#include "app/serve/message.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <nlohmann/json.hpp>

#include "app/serve/key_codes.h"

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

using Body = decltype(ClientMessage::body);

struct MessageRow {
  std::string_view type;
  Body (*read)(MessageReader& reader);
};

constexpr std::array kMessages = {
    MessageRow{"hello",
               [](MessageReader& r) -> Body {
                 return message::Hello{r.text("token"), r.size()};
               }},
    MessageRow{"resize", [](MessageReader& r) -> Body { return message::Resize{r.size()}; }},
    MessageRow{"key",
               [](MessageReader& r) -> Body {
                 return message::Key{key_of_code(r.text("code")), r.flag("down"), r.set("repeat"),
                                     r.mods()};
               }},
    MessageRow{"button",
               [](MessageReader& r) -> Body {
                 const auto button = static_cast<int>(r.whole("button", 0, 2));
                 return message::Button{button, r.flag("down"), r.place()};
               }},
    MessageRow{"cursor", [](MessageReader& r) -> Body { return message::Cursor{r.place()}; }},
    MessageRow{"wheel",
               [](MessageReader& r) -> Body {
                 return message::Wheel{r.real("notches", kMostNotches), r.mods()};
               }},
    MessageRow{"command",
               [](MessageReader& r) -> Body { return message::Command{r.text("command")}; }},
    MessageRow{"scene",
               [](MessageReader& r) -> Body {
                 return message::ShowScene{r.whole("scene", 0, kMostScene)};
               }},
    MessageRow{"set",
               [](MessageReader& r) -> Body {
                 message::SetControl set{r.text("control"), r.real("value", kMostValue)};
                 if (r.object.contains("index")) set.index = r.whole("index", 0, ~0u);
                 return set;
               }},
    MessageRow{"handle",
               [](MessageReader& r) -> Body {
                 const auto face = static_cast<int>(r.whole("face", 0, 5));
                 return message::DragHandle{face, r.place()};
               }},
    MessageRow{"view",
               [](MessageReader& r) -> Body {
                 const std::size_t scene = r.whole("scene", 0, kMostScene);
                 std::string camera = r.text("camera", kMostCamera);
                 return message::ShowView{scene, std::move(camera), r.text("mode")};
               }},
    MessageRow{
        "panels",
        [](MessageReader& r) -> Body { return message::ShowPanels{r.texts("open", kMostPanels)}; }},
    MessageRow{"stop", [](MessageReader&) -> Body { return message::Stop{}; }},
    MessageRow{"received",
               [](MessageReader& r) -> Body {
                 return message::Received{r.whole("count", 0, ~0u), r.held()};
               }},
    MessageRow{"video", [](MessageReader& r) -> Body { return message::Video{r.flag("decodes")}; }},
    MessageRow{"blur", [](MessageReader&) -> Body { return message::Blur{}; }},
};

}  // namespace

std::optional<ClientMessage> parse_message(std::string_view text) {
  const Json object = Json::parse(text, nullptr, false);
  if (!object.is_object()) return {};
  MessageReader reader{object};
  const std::string type = reader.text("type");
  const auto row = std::find_if(kMessages.begin(), kMessages.end(),
                                [&](const MessageRow& one) { return one.type == type; });
  if (row == kMessages.end()) return {};
  ClientMessage parsed;
  if (object.contains("input")) parsed.input = reader.whole("input", 0, ~0u);
  parsed.body = row->read(reader);
  if (!reader.sound) return {};
  return parsed;
}

}  // namespace qs
