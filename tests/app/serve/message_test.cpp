// SPDX-License-Identifier: MIT
//
// The messages of the page: what is taken, and what is refused.
#include "app/serve/message.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/serve/served_commands.h"
#include "app/viewer/commands/keys.h"

namespace qs {
namespace {

template <class Body>
Body body_of(std::string_view text) {
  const auto parsed = parse_message(text);
  if (!parsed || !std::holds_alternative<Body>(parsed->body)) {
    ADD_FAILURE() << text;
    return {};
  }
  return std::get<Body>(parsed->body);
}

TEST(ServeMessage, each_kind_is_read) {
  const auto hello =
      body_of<message::Hello>(R"({"type":"hello","token":"abc","width":640,"height":480})");
  EXPECT_EQ(hello.token, "abc");
  EXPECT_EQ(hello.size, glm::ivec2(640, 480));
  EXPECT_EQ(body_of<message::Resize>(R"({"type":"resize","width":1,"height":4096})").size.y, 4096);
  const auto key = body_of<message::Key>(
      R"({"type":"key","code":"KeyH","down":true,"repeat":false,"shift":true,"alt":false})");
  EXPECT_EQ(key.key, GLFW_KEY_H);
  EXPECT_EQ(key.mods, GLFW_MOD_SHIFT);
  EXPECT_TRUE(key.down);
  const auto button =
      body_of<message::Button>(R"({"type":"button","button":2,"down":true,"x":1.5,"y":-3})");
  EXPECT_EQ(button.button, GLFW_MOUSE_BUTTON_MIDDLE);
  EXPECT_EQ(button.at, glm::dvec2(1.5, -3));
  EXPECT_EQ(body_of<message::Cursor>(R"({"type":"cursor","x":7,"y":8})").at, glm::dvec2(7, 8));
  EXPECT_EQ(body_of<message::Wheel>(R"({"type":"wheel","notches":-2,"ctrl":true})").mods,
            GLFW_MOD_CONTROL);
  EXPECT_EQ(body_of<message::Command>(R"({"type":"command","command":"Heat map"})").help,
            "Heat map");
  EXPECT_EQ(body_of<message::ShowScene>(R"({"type":"scene","scene":3})").scene, 3u);
  const auto set = body_of<message::SetControl>(
      R"({"type":"set","control":"splat scale","value":-1.5,"index":4294967295})");
  EXPECT_EQ(set.control, "splat scale");
  EXPECT_EQ(set.value, -1.5);
  EXPECT_EQ(set.index, 4294967295u);
  EXPECT_EQ(body_of<message::SetControl>(R"({"type":"set","control":"","value":0})").index, 0u);
  const auto handle = body_of<message::DragHandle>(R"({"type":"handle","face":5,"x":1,"y":2})");
  EXPECT_EQ(handle.face, 5);
  EXPECT_EQ(handle.at, glm::dvec2(1, 2));
  const auto view = body_of<message::ShowView>(
      R"({"type":"view","scene":2,"camera":"{\"id\":0}","mode":"exact"})");
  EXPECT_EQ(view.scene, 2u);
  EXPECT_EQ(view.camera, R"({"id":0})");
  EXPECT_EQ(view.mode, "exact");
  body_of<message::Stop>(R"({"type":"stop"})");
  EXPECT_EQ(body_of<message::Received>(R"({"type":"received","count":9})").count, 9u);
  EXPECT_EQ(body_of<message::Received>(R"({"type":"received","count":9,"held":12.5})").held, 12.5);
  EXPECT_TRUE(body_of<message::Video>(R"({"type":"video","decodes":true})").decodes);
  EXPECT_FALSE(body_of<message::Video>(R"({"type":"video","decodes":false})").decodes);
  const auto file =
      body_of<message::OpenFile>(R"({"type":"file","name":"a.edits.json","text":"{}"})");
  EXPECT_EQ(file.name, "a.edits.json");
  EXPECT_EQ(file.text, "{}");
  body_of<message::Blur>(R"({"type":"blur"})");
  EXPECT_EQ(parse_message(R"({"type":"blur","input":4294967295})")->input, 4294967295u);
}

TEST(ServeMessage, all_else_is_refused) {
  for (const char* text : {"",
                           "{",
                           "7",
                           "[]",
                           "null",
                           "{}",
                           R"({"type":7})",
                           R"({"type":"quit"})",
                           R"({"type":"hello","token":7,"width":1,"height":1})",
                           R"({"type":"hello","token":"a","width":0,"height":1})",
                           R"({"type":"resize","width":4097,"height":1})",
                           R"({"type":"resize","width":-1,"height":1})",
                           R"({"type":"resize","width":1.5,"height":1})",
                           R"({"type":"resize","width":1})",
                           R"({"type":"cursor","x":1e300,"y":0})",
                           R"({"type":"cursor","x":null,"y":0})",
                           R"({"type":"wheel","notches":101})",
                           R"({"type":"key","code":"KeyW"})",
                           R"({"type":"key","code":"KeyW","down":1})",
                           R"({"type":"key","code":"KeyW","down":true,"shift":"yes"})",
                           R"({"type":"button","button":3,"down":true,"x":0,"y":0})",
                           R"({"type":"received","count":4294967296})",
                           R"({"type":"received","count":1,"held":-1})",
                           R"({"type":"received","count":1,"held":10001})",
                           R"({"type":"received","count":1,"held":"long"})",
                           R"({"type":"video"})",
                           R"({"type":"video","decodes":1})",
                           R"({"type":"blur","input":-1})",
                           R"({"type":"file","name":"../a.edits.json","text":"{}"})",
                           R"({"type":"file","name":"a.edits.json"})",
                           R"({"type":"scene","scene":"/etc/passwd"})",
                           R"({"type":"set","control":"x"})",
                           R"({"type":"set","control":7,"value":1})",
                           R"({"type":"set","control":"x","value":"1"})",
                           R"({"type":"set","control":"x","value":1e10})",
                           R"({"type":"set","control":"x","value":1,"index":-1})",
                           R"({"type":"set","control":"x","value":1,"index":1.5})",
                           R"({"type":"handle","face":6,"x":1,"y":2})",
                           R"({"type":"handle","face":0,"x":1e6,"y":2})",
                           R"({"type":"panels"})",
                           R"({"type":"panels","open":"Training"})",
                           R"({"type":"panels","open":[7]})",
                           R"({"type":"view","scene":0,"camera":{},"mode":"exact"})",
                           R"({"type":"view","scene":0,"camera":"{}"})",
                           R"({"type":"view","scene":-1,"camera":"{}","mode":"exact"})",
                           "{\"type\":\"blur\"}\xff"}) {
    EXPECT_FALSE(parse_message(text)) << text;
  }
  const std::string longest(200, 'x'), longer(201, 'x');
  EXPECT_TRUE(parse_message(R"({"type":"command","command":")" + longest + R"("})"));
  EXPECT_FALSE(parse_message(R"({"type":"command","command":")" + longer + R"("})"));
  const std::string camera(kMostCamera, ' '), more(kMostCamera + 1, ' ');
  EXPECT_TRUE(parse_message(R"({"type":"view","scene":0,"mode":"","camera":")" + camera + R"("})"));
  EXPECT_FALSE(parse_message(R"({"type":"view","scene":0,"mode":"","camera":")" + more + R"("})"));
  EXPECT_FALSE(parse_message(std::string(60000, '[')));
}

TEST(ServeMessage, browsers_have_every_key_that_visitors_may_use) {
  const auto has_code = [](int key) {
    for (int code = 0; code < 26; ++code) {
      if (key_of_code(fmt::format("Key{}", static_cast<char>('A' + code))) == key) return true;
      if (code < 10 && key_of_code(fmt::format("Digit{}", code)) == key) return true;
    }
    for (const char* code :
         {"Space", "Minus", "Equal", "BracketLeft", "BracketRight", "Backquote", "Home",
          "Backspace", "F9", "F10", "Delete", "Escape", "Comma", "Period", "Enter", "ArrowLeft",
          "ArrowRight", "ArrowUp", "ArrowDown"}) {
      if (key_of_code(code) == key) return true;
    }
    return false;
  };
  EXPECT_EQ(served_commands().size(), 70u + static_cast<std::size_t>(culler_count()))
      << "a name in the list of served commands is not one of the window's commands";
  for (const KeyCommand* command : served_commands())
    EXPECT_TRUE(has_code(command->key)) << command->help;
  for (const FlyKey& key : fly_keys()) EXPECT_TRUE(has_code(key.key)) << key.help;
  EXPECT_EQ(key_of_code("KeyAA"), 0);
  EXPECT_EQ(key_of_code("Key"), 0);
  EXPECT_EQ(key_of_code("F11"), 0);
  EXPECT_EQ(key_of_code("F0"), 0);
}

}  // namespace
}  // namespace qs
