// SPDX-License-Identifier: MIT
//
// Preferences as JSON. Apart from preferences.cpp so that the fuzzer builds without the rest of the
// application.
#include <algorithm>

#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "app/viewer/preferences.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostScenes = 100;
constexpr std::size_t kMostPathBytes = std::size_t{2} << 20;  ///< of all keyframes and bookmarks

/// Calls visit(name, member) for the members that JSON stores directly.
template <class V, class Size, class Visit>
void for_each_preference(V& viewer, Size& window_size, Visit&& visit) {
  visit("width", window_size.x);
  visit("height", window_size.y);
  visit("vsync", viewer.vsync);
  visit("on_demand", viewer.on_demand);
  visit("reduce_when_moving", viewer.reduce_when_moving);
  visit("occlusion", viewer.occlusion);
  visit("hud", viewer.panels.hud);
  visit("info", viewer.panels.info);
  visit("cameras_panel", viewer.panels.cameras);
  visit("left_bar", viewer.bars.left);
  visit("right_bar", viewer.bars.right);
  visit("cameras", viewer.last_views);
  visit("up", viewer.ups);
  visit("axes", viewer.axes);
  visit("first_views", viewer.first_views);
  visit("interface_scale", viewer.interface_scale);
  visit("keyframes", viewer.kept_paths);
  visit("bookmarks", viewer.bookmarks);
  visit("mode", viewer.settings.mode);
}

}  // namespace

void parse_preferences(const std::string& text, Viewer& viewer, glm::ivec2& window_size) {
  const ordered_json json = parse_own_json(text);
  Viewer read = viewer;
  glm::ivec2 size = window_size;
  for_each_preference(read, size, [&](const char* name, auto& value) {
    if (json.contains(name)) json_value(json.at(name), value);
  });
  for (float* letters : {&read.bars.left, &read.bars.right})
    *letters = std::clamp(*letters, 0.0f, 1000.0f);
  if (read.interface_scale != 0)
    read.interface_scale = std::clamp(read.interface_scale, 0.75f, 3.0f);
  read.navigation =
      json.value("navigation", "orbit") == "fly" ? Navigation::fly : Navigation::orbit;
  read.light_theme = json.value("theme", "dark") == "light";
  const auto map = std::ranges::find(kHeatmaps, json.value("heat_map", ""), &HeatmapRow::name);
  if (map != kHeatmaps.end())
    read.heatmap = read.last_heatmap = static_cast<HeatQuantity>(map - kHeatmaps.begin());
  for (const auto& path : json.value("recent", std::vector<std::string>()))
    read.recent.emplace_back(path);
  // A size that the file does not name stays, also if it is 0: not chosen yet.
  if (size != window_size) window_size = glm::clamp(size, glm::ivec2(320, 240), glm::ivec2(16384));
  viewer = std::move(read);
}

std::string format_preferences(const Viewer& viewer, glm::ivec2 window_size) {
  ordered_json json;
  for_each_preference(viewer, window_size,
                      [&](const char* name, const auto& value) { json[name] = value; });
  if (viewer.scene) json["cameras"][viewer.scene->path.string()] = format_camera(viewer.camera);
  for (const char* name : {"cameras", "up", "axes", "first_views", "keyframes", "crops"})
    while (json[name].size() > kMostScenes) json[name].erase(json[name].begin());
  std::size_t bytes = 0;
  for (const auto& [scene, path] : viewer.kept_paths)
    if ((bytes += path.size()) > kMostPathBytes) json["keyframes"].erase(scene);
  for (const auto& [scene, views] : viewer.bookmarks)
    for (const auto& [name, view] : views)
      if ((bytes += name.size() + view.size()) > kMostPathBytes) json["bookmarks"].erase(scene);
  if (viewer.heatmap) json["heat_map"] = heatmap_row(*viewer.heatmap).name;
  json["navigation"] = viewer.navigation == Navigation::fly ? "fly" : "orbit";
  json["theme"] = viewer.light_theme ? "light" : "dark";
  json["recent"] = ordered_json::array();
  for (const auto& path : viewer.recent) json["recent"].push_back(path.string());
  return json_file_text(json);
}

}  // namespace qs
