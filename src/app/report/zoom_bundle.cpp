// SPDX-License-Identifier: MIT
#include "app/report/zoom_bundle.h"

#include "app/measure/noise.h"
#include "base/fail.h"
#include "base/json_of.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

ordered_json settings_json(const RenderSettings& settings) {
  return {{"sh_degree", settings.sh_degree},
          {"splat_scale", settings.splat_scale},
          {"background", json_of(settings.background)},
          {"antialiased", json_of(settings.antialiased)}};
}

template <class Vector>
void read_vector(const ordered_json& json, Vector& vector) {
  for (int c = 0; c < 3; ++c) json.at(static_cast<std::size_t>(c)).get_to(vector[c]);
}

RenderSettings read_settings(const ordered_json& json) {
  RenderSettings settings;
  json_value(json.at("sh_degree"), settings.sh_degree);
  json.at("splat_scale").get_to(settings.splat_scale);
  read_vector(json.at("background"), settings.background);
  if (!json.at("antialiased").is_null()) settings.antialiased = json["antialiased"].get<bool>();
  return settings;
}

}  // namespace

std::string format_zoom_json(const ZoomBundle& bundle) {
  ordered_json modes = ordered_json::array();
  for (const CullMode mode : bundle.modes) modes.push_back(mode_name(mode));
  ordered_json json = {{"environment", bundle.environment},
                       {"scene", bundle.scene.string()},
                       {"scene_hash", bundle.scene_hash},
                       {"start", camera_json(bundle.start)},
                       {"target", {bundle.target.x, bundle.target.y, bundle.target.z}},
                       {"steps", bundle.steps},
                       {"closest", bundle.closest},
                       {"modes", modes},
                       {"settings", settings_json(bundle.settings)},
                       {"noisy_steps", noisy_steps(bundle.rows)},
                       {"rows", rows_json(bundle.rows)}};
  return json_file_text(json);
}

ZoomBundle read_zoom_json(const std::filesystem::path& path) try {
  const ordered_json json = parse_own_json(read_text_file(path, kMaxReportBytes));
  ZoomBundle bundle;
  bundle.environment = json.at("environment");
  bundle.scene = json.at("scene").get<std::string>();
  json.at("scene_hash").get_to(bundle.scene_hash);
  bundle.start = camera_of(json.at("start"), path.string());
  read_vector(json.at("target"), bundle.target);
  json_value(json.at("steps"), bundle.steps);
  json.at("closest").get_to(bundle.closest);
  if (bundle.steps < 2 || bundle.steps > 100000 || !(bundle.closest > 0)) {
    fail("{}: steps or closest is out of range", path.string());
  }
  for (const ordered_json& name : json.at("modes")) {
    const CullMode mode = find_culler(name.get<std::string>());
    if (mode < 0) fail("{}: there is no mode {}", path.string(), json_line(name));
    bundle.modes.push_back(mode);
  }
  bundle.settings = read_settings(json.at("settings"));
  bundle.rows = read_rows(json.at("rows"));
  return bundle;
} catch (const nlohmann::json::exception& error) {
  fail("{}: is not a zoom's zoom.json: {}", path.string(), error.what());
}

std::vector<std::string> count_differences(const std::vector<BenchRow>& recorded,
                                           const std::vector<BenchRow>& replayed) {
  std::vector<std::string> sentences;
  if (recorded.size() != replayed.size()) {
    sentences.push_back(
        fmt::format("the bundle has {} rows, the replay {}", recorded.size(), replayed.size()));
    return sentences;
  }
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    const BenchRow &was = recorded[i], &is = replayed[i];
    if (was.mode == is.mode && was.pairs == is.pairs && was.visible == is.visible) continue;
    sentences.push_back(fmt::format("step {}, {}: {} pairs of {} Gaussians, recorded {} of {}",
                                    is.camera, is.mode, is.pairs, is.visible, was.pairs,
                                    was.visible));
  }
  return sentences;
}

}  // namespace qs
