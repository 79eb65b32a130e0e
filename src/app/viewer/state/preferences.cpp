// SPDX-License-Identifier: MIT
#include "app/viewer/state/preferences.h"

#include <cstdlib>
#include <system_error>

#include <fmt/format.h>
#include <glm/common.hpp>
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
template <class V, class Size, class Visit>
void for_each_preference(V& viewer, Size& window_size, Visit&& visit) {
  visit("width", window_size.x);
  visit("height", window_size.y);
  visit("vsync", viewer.vsync);
  visit("on_demand", viewer.on_demand);
  visit("reduce_when_moving", viewer.reduce_when_moving);
  visit("hud", viewer.panels.hud);
  visit("info", viewer.panels.info);
  visit("cameras_panel", viewer.panels.cameras);
  visit("cameras", viewer.last_views);
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

std::string read_preferences(const std::filesystem::path& file, Viewer& viewer,
                             glm::ivec2& window_size) {
  std::error_code error;
  if (file.empty() || !std::filesystem::exists(file, error)) return "";
  try {
    const ordered_json json = ordered_json::parse(read_text_file(file, kMaxBytes));
    Viewer read = viewer;
    glm::ivec2 size = window_size;
    for_each_preference(read, size, [&](const char* name, auto& value) {
      if (json.contains(name)) json.at(name).get_to(value);
    });
    read.navigation =
        json.value("navigation", "orbit") == "fly" ? Navigation::fly : Navigation::orbit;
    for (const auto& path : json.value("recent", std::vector<std::string>()))
      read.recent.emplace_back(path);
    window_size = glm::clamp(size, glm::ivec2(320, 240), glm::ivec2(16384));
    viewer = std::move(read);
    return "";
  } catch (const std::exception& why) {
    return fmt::format("{}: the settings cannot be read and are ignored: {}", file.string(),
                       why.what());
  }
}

void write_preferences(const std::filesystem::path& file, const Viewer& viewer,
                       glm::ivec2 window_size) {
  if (file.empty()) return;
  ordered_json json;
  for_each_preference(viewer, window_size,
                      [&](const char* name, const auto& value) { json[name] = value; });
  if (viewer.scene) json["cameras"][viewer.scene->path.string()] = format_camera(viewer.camera);
  while (json["cameras"].size() > kMostCameras) json["cameras"].erase(json["cameras"].begin());
  json["navigation"] = viewer.navigation == Navigation::fly ? "fly" : "orbit";
  json["recent"] = ordered_json::array();
  for (const auto& path : viewer.recent) json["recent"].push_back(path.string());
  make_folder(file.parent_path());
  write_stats(file, json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace qs
