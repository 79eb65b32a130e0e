// SPDX-License-Identifier: MIT
//
// Preferences as JSON. Apart from preferences.cpp so that the fuzzer builds without the rest of the
// application.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/viewer/state/preferences.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostCameras = 100;

/// Calls visit(name, member) for what is stored as it is.
template <class P, class Visit>
void for_each_preference(P& p, Visit&& visit) {
  visit("width", p.width);
  visit("height", p.height);
  visit("vsync", p.vsync);
  visit("on_demand", p.on_demand);
  visit("reduce_when_moving", p.reduce_when_moving);
  visit("hud", p.panels.hud);
  visit("info", p.panels.info);
  visit("cameras_panel", p.panels.cameras);
  visit("cameras", p.cameras);
}

}  // namespace

Preferences parse_preferences(const std::string& text, const std::string& source,
                              std::string& problem) {
  Preferences preferences;
  try {
    const ordered_json json = ordered_json::parse(text);
    for_each_preference(preferences, [&](const char* name, auto& value) {
      if (json.contains(name)) json.at(name).get_to(value);
    });
    preferences.navigation =
        json.value("navigation", "orbit") == "fly" ? Navigation::fly : Navigation::orbit;
    for (const auto& path : json.value("recent", std::vector<std::string>()))
      preferences.recent.emplace_back(path);
    preferences.width = std::clamp(preferences.width, 320, 16384);
    preferences.height = std::clamp(preferences.height, 240, 16384);
  } catch (const std::exception& why) {
    problem =
        fmt::format("{}: the settings cannot be read and are ignored: {}", source, why.what());
    return {};
  }
  return preferences;
}

std::string format_preferences(const Preferences& preferences) {
  ordered_json json;
  for_each_preference(preferences,
                      [&](const char* name, const auto& value) { json[name] = value; });
  while (json["cameras"].size() > kMostCameras) json["cameras"].erase(json["cameras"].begin());
  json["navigation"] = preferences.navigation == Navigation::fly ? "fly" : "orbit";
  json["recent"] = ordered_json::array();
  for (const auto& path : preferences.recent) json["recent"].push_back(path.string());
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace qs
