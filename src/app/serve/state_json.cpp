// SPDX-License-Identifier: MIT
#include "app/serve/state_json.h"

#include <algorithm>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/serve/served_commands.h"
#include "app/viewer/commands/keys.h"
#include "app/viewer/state/hud_text.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

using Json = nlohmann::json;

Json commands_json(bool trains) {
  return json_list(served_commands(), [&](const KeyCommand* command) -> Json {
    if (is_of_training(*command) && !trains) return nullptr;
    const bool has_menu = command->menu != Menu::none;
    return {{"menu", has_menu ? kMenuNames[static_cast<std::size_t>(command->menu)] : ""},
            {"help", command->help},
            {"key", key_name(command->key, command->mods)},
            {"held", static_cast<bool>(command->on_release)},
            {"tooltip", command->tooltip == nullptr ? "" : command->tooltip}};
  });
}

Json help_json() {
  Json rows = Json::array();
  for (const Gesture& gesture : gestures()) {
    if (gesture.keys != std::string_view("Drop a file"))  // not on a page
      rows.push_back({gesture.keys, gesture.help});
  }
  for (const FlyKey& key : fly_keys()) rows.push_back({key_name(key.key), key.help});
  return rows;
}

Json scene_json(const OpenedScene* scene) {
  return {{"name", scene->facts.name}, {"gaussians", scene->facts.gaussians}};
}

Json view_json(const Visitor& visitor) {
  const Viewer& v = visitor.viewer();
  const auto if_checked = [&](const KeyCommand* command) {
    return command->is_checked && command->is_checked(v) ? Json(command->help) : Json();
  };
  return {{"scene", visitor.scene()},
          {"title", window_title(v)},
          {"navigation", v.navigation == Navigation::orbit ? "orbit" : "fly"},
          {"mode", mode_name(v.mode())},
          {"heatmap", v.heatmap ? heatmap_row(*v.heatmap).name : ""},
          {"quantity", row_of(v.quantity).name},
          {"camera", v.dataset_camera},
          {"cameras", v.scene->cameras.size()},
          {"pose", format_camera(v.camera)},
          {"checked", json_list(served_commands(), if_checked)}};
}

Json messages_json(const Viewer& v) {
  constexpr std::size_t kMost = 6;  // the newest
  const auto newest = std::span(v.toasts).last(std::min(kMost, v.toasts.size()));
  return json_list(newest, [&](const Toast& toast) -> Json {
    if (!toast.path.empty()) return nullptr;
    return {{"text", public_text(v, toast.text)}, {"error", toast.error}};
  });
}

}  // namespace

StateSections state_sections(const Visitor& visitor,
                             const std::vector<const OpenedScene*>& scenes) {
  const auto text = [](const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
  };
  static const std::string kCommands[] = {text(commands_json(false)), text(commands_json(true))},
                           kHelp = text(help_json());
  StateSections sections = {{"commands", kCommands[visitor.viewer().training ? 1 : 0]},
                            {"help", kHelp},
                            {"scenes", text(json_list(scenes, scene_json))},
                            {"view", text(view_json(visitor))},
                            {"messages", text(messages_json(visitor.viewer()))}};
  const Json panels = panel_sections(visitor);
  for (const auto& [name, value] : panels.items()) sections[name] = text(value);
  return sections;
}

std::string state_message(const StateSections& before, const StateSections& now,
                          std::uint32_t version) {
  std::string sections;
  for (const auto& [name, value] : now) {
    const auto found = before.find(name);
    if (found != before.end() && found->second == value) continue;
    sections += fmt::format("{}\"{}\":{}", sections.empty() ? "" : ",", name, value);
  }
  if (sections.empty()) return {};
  return fmt::format(R"({{"type":"state","version":{},"sections":{{{}}}}})", version, sections);
}

}  // namespace qs
