// SPDX-License-Identifier: MIT
#include "app/serve/state_json.h"

#include <algorithm>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/serve/panel_json.h"
#include "app/serve/served_commands.h"
#include "app/viewer/commands/keys.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

using Json = nlohmann::json;

// Files cannot be dropped on a page.
bool works_in_browsers(const Gesture& gesture) {
  return std::string_view(gesture.keys) != "Drop a file";
}

Json commands_json(bool trains) {
  Json rows = Json::array();
  for (const KeyCommand* command : served_commands()) {
    if (is_of_training(*command) && !trains) continue;
    rows.push_back(
        {{"menu",
          command->menu == Menu::none ? "" : kMenuNames[static_cast<std::size_t>(command->menu)]},
         {"help", command->help},
         {"key", key_name(command->key, command->mods)},
         {"held", static_cast<bool>(command->on_release)},
         {"tooltip", command->tooltip == nullptr ? "" : command->tooltip}});
  }
  return rows;
}

Json help_json() {
  Json rows = Json::array();
  for (const Gesture& gesture : gestures()) {
    if (works_in_browsers(gesture)) rows.push_back({gesture.keys, gesture.help});
  }
  for (const FlyKey& key : fly_keys()) rows.push_back({key_name(key.key), key.help});
  return rows;
}

Json scenes_json(const std::vector<const OpenedScene*>& scenes) {
  Json rows = Json::array();
  for (const OpenedScene* scene : scenes)
    rows.push_back({{"name", scene->facts.name}, {"gaussians", scene->facts.gaussians}});
  return rows;
}

Json view_json(const Visitor& visitor) {
  const Viewer& v = visitor.viewer();
  Json checked = Json::array();
  for (const KeyCommand* command : served_commands()) {
    if (command->is_checked && command->is_checked(v)) checked.push_back(command->help);
  }
  const std::string map = v.heatmap ? heatmap_row(*v.heatmap).name : "";
  return {{"scene", visitor.scene()},
          {"navigation", v.navigation == Navigation::orbit ? "orbit" : "fly"},
          {"mode", mode_name(v.mode())},
          {"heatmap", map},
          {"quantity", row_of(v.quantity).name},
          {"camera", v.dataset_camera},
          {"cameras", v.scene->cameras.size()},
          {"pose", format_camera(v.camera)},
          {"checked", checked}};
}

Json messages_json(const Viewer& v) {
  constexpr std::ptrdiff_t kMost = 6;  // the newest
  Json rows = Json::array();
  for (const Toast& toast :
       std::span(v.toasts).last(static_cast<std::size_t>(std::min(kMost, std::ssize(v.toasts))))) {
    if (toast.path.empty())
      rows.push_back({{"text", public_text(v, toast.text)}, {"error", toast.error}});
  }
  return rows;
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
                            {"scenes", text(scenes_json(scenes))},
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
