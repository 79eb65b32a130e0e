// SPDX-License-Identifier: MIT
#include "app/viewer/state/preferences.h"

#include <algorithm>
#include <cstdlib>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/report/stats_file.h"
#include "app/report/write_report.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMaxBytes = std::size_t{4} << 20, kMostCameras = 100;

/// Calls visit(name, member) for the members that JSON stores directly.
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

std::filesystem::path preferences_file() {
  const char* config = std::getenv("XDG_CONFIG_HOME");
  if (config != nullptr && *config != '\0')
    return std::filesystem::path(config) / "quadsplat/viewer.json";
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0') return {};
  return std::filesystem::path(home) / ".config/quadsplat/viewer.json";
}

void use_preferences(Viewer& viewer, const Preferences& preferences) {
  viewer.vsync = preferences.vsync;
  viewer.on_demand = preferences.on_demand;
  viewer.reduce_when_moving = preferences.reduce_when_moving;
  viewer.panels = preferences.panels;
  viewer.navigation = preferences.navigation;
  viewer.recent = preferences.recent;
  viewer.last_views = preferences.cameras;
}

Preferences preferences_of(const Viewer& viewer, glm::ivec2 window_size) {
  Preferences kept{
      window_size.x, window_size.y,     viewer.vsync,  viewer.on_demand, viewer.reduce_when_moving,
      viewer.panels, viewer.navigation, viewer.recent, viewer.last_views};
  if (viewer.scene) kept.cameras[viewer.scene->path.string()] = format_camera(viewer.camera);
  return kept;
}

Preferences read_preferences(const std::filesystem::path& file, std::string& problem) {
  Preferences preferences;
  std::error_code error;
  if (file.empty() || !std::filesystem::exists(file, error)) return preferences;
  try {
    const ordered_json json = ordered_json::parse(read_text_file(file, kMaxBytes));
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
    problem = fmt::format("{}: the settings cannot be read and are ignored: {}", file.string(),
                          why.what());
    return {};
  }
  return preferences;
}

void write_preferences(const std::filesystem::path& file, const Preferences& preferences) {
  if (file.empty()) return;
  ordered_json json;
  for_each_preference(preferences,
                      [&](const char* name, const auto& value) { json[name] = value; });
  while (json["cameras"].size() > kMostCameras) json["cameras"].erase(json["cameras"].begin());
  json["navigation"] = preferences.navigation == Navigation::fly ? "fly" : "orbit";
  json["recent"] = ordered_json::array();
  for (const auto& path : preferences.recent) json["recent"].push_back(path.string());
  make_folder(file.parent_path());
  write_stats(file, json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace qs
