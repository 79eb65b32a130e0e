// SPDX-License-Identifier: MIT
#include "app/report/environment.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/measure/scene_facts.h"
#include "app/session/alterations.h"
#include "base/environment.h"
#include "base/json_of.h"
#include "io/bytes/file_hash.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

// Four decimals of a millisecond exceed the resolution of the clocks.
double rounded_ms(float ms) { return std::round(static_cast<double>(ms) * 1e4) / 1e4; }

// JSON has no infinity: the PSNR of equal pictures is null.
ordered_json frame_json(const FrameRecord& record) {
  const RenderStats& stats = record.result.stats;
  ordered_json stages;
  for (int stage = 0; stage < kStageCount; ++stage)
    stages[kStageNames[stage]] = rounded_ms(stats.stage_ms[stage]);
  ordered_json frame = {{"view", record.view},
                        {"mode", mode_name(record.result.mode)},
                        {"width", record.shot.camera.width},
                        {"height", record.shot.camera.height},
                        {"gaussians", stats.gaussians},
                        {"visible", stats.visible},
                        {"tile_pairs", stats.tile_pairs},
                        {"pairs_per_visible", pairs_per_visible(stats)},
                        {"max_pairs_in_a_tile", stats.max_pairs_in_a_tile},
                        {"frame_ms", rounded_ms(stats.frame_ms)},
                        {"stage_ms", stages},
                        {"pipeline", kPipelineNames[static_cast<int>(stats.pipeline)]},
                        {"threads", stats.threads}};
  if (stats.is_occluded) frame["listed"] = stats.listed;
  if (stats.used_pairs) frame["used_pairs"] = *stats.used_pairs;
  if (record.result.psnr) frame["psnr_vs_reference"] = finite_or_null(*record.result.psnr);
  if (record.reference_psnr) frame["psnr_vs_picture"] = finite_or_null(*record.reference_psnr);
  if (!record.picture.empty()) frame["picture"] = record.picture;
  if (record.shot.number >= 0) frame["camera_index"] = record.shot.number;
  frame["camera"] = camera_json(record.shot.camera);
  return frame;
}

constexpr const char *kClock = "gpu_clock", *kText = "gpu_clock_text";

ordered_json range_json(const std::optional<SensorRange>& range) {
  if (!range) return nullptr;
  return {{"median", range->median}, {"min", range->min}, {"max", range->max}};
}

/// The sentence below the tables that defines the timed part of a plugin's frame.
constexpr const char* kTimingScope =
    "Times of plugins, as those of the modes, are from the camera's arrival to the finished image "
    "in the renderer's memory (on its device). Reading and uploading the scene and copying the "
    "image to the host are not included";

}  // namespace

ordered_json environment_json(const Session& session) {
  const Environment environment = read_environment();
  ordered_json json = {{"version", environment.version},
                       {"commit", environment.commit},
                       {"build_type", environment.build_type},
                       {"sanitizers", environment.sanitizers},
                       {"cuda_toolkit", environment.cuda_toolkit},
                       {"cpu", environment.cpu},
                       {"hardware_threads", environment.hardware_threads},
                       {"threads", session.pool ? session.pool->size() : 0},
                       {"backend", kBackendNames[static_cast<int>(session.backend)]},
                       {"pipeline", pipeline_name(session.backend, session.settings.pipeline)},
                       {"utc", environment.utc}};
  if (session.backend == Backend::cuda) {
    const std::string name = inspect_gpu(session.device).name;
    json["gpu"] = name.empty() ? "unknown" : name;
    json["cuda_of_driver"] = cuda_versions().driver;
  }
  return json;
}

ordered_json scene_json(const Session& session) {
  const Scene& scene = *session.scene;
  ordered_json json = {{"file", scene.path.string()},
                       {"hash", file_hash(scene.path)},
                       {"format", scene.format},
                       {"bytes", scene.file_bytes},
                       {"gaussians", drawn_count(session)},
                       {"sh_degree", scene.cloud.sh_degree},
                       {"antialiased", scene.cloud.antialiased}};
  alterations_of(session).add_to(json);
  return json;
}

std::string format_stats(const Session& session, const std::vector<FrameRecord>& frames,
                         std::size_t view_count) {
  ordered_json json = {{"environment", environment_json(session)},
                       {"scene", scene_json(session)},
                       {"view_count", view_count},
                       {"frames", ordered_json::array()}};
  for (const FrameRecord& record : frames) json["frames"].push_back(frame_json(record));
  return json_file_text(json);
}

GpuClock clock_of(const Session& session) {
  return GpuClock(session.backend == Backend::cuda ? gpu_sensors(session.device) : GpuSensors());
}

void add_clock(ordered_json& environment, const GpuClock& clock) {
  if (environment.value("backend", "") != kBackendNames[static_cast<int>(Backend::cuda)]) return;
  const std::optional<GpuClockSummary> summary = clock.summary();
  environment[kClock] = nullptr;
  if (summary)
    environment[kClock] = {{"readings", summary->readings},
                           {"sm_mhz", range_json(summary->sm_mhz)},
                           {"sm_mhz_max", json_of(summary->sm_mhz_max)},
                           {"throttled", json_of(summary->throttled)},
                           {"celsius", range_json(summary->celsius)},
                           {"watts", range_json(summary->watts)}};
  environment[kText] =
      ordered_json::array({clock_text(environment.value("gpu", "unknown"), summary)});
  if (const std::string warning = throttle_warning(summary); !warning.empty())
    environment[kText].push_back("Warning: " + warning);
}

std::vector<std::string> clock_lines(const ordered_json& environment) {
  return environment.value(kText, std::vector<std::string>());
}

std::string plugin_line(const PluginFacts& facts) {
  const std::string how =
      facts.measures_itself
          ? fmt::format(
                "its times are measured by the plugin, and its calls on {} took {:.2f} "
                "times as long by the host's clock",
                facts.scene, facts.call_factor)
          : "its times are those of its calls by the host's clock";
  return fmt::format("`{}`: {}{}{}; scene and image in {} memory; {}", facts.name,
                     facts.description, facts.description.empty() ? "" : "; ", facts.file,
                     facts.on_device ? "CUDA" : "host", how);
}

void add_line(ordered_json& environment, const char* key, const std::string& line) {
  ordered_json& list = environment[key];
  if (list.is_null()) list = ordered_json::array();
  if (std::find(list.begin(), list.end(), line) == list.end()) list.push_back(line);
}

std::string plugin_markdown(const ordered_json& environment) {
  const auto lines = [&](const char* key) { return environment.value(key, ordered_json::array()); };
  std::string text;
  for (const ordered_json& line : lines("plugins"))
    text += fmt::format("- {}\n", line.get<std::string>());
  if (!text.empty()) text = fmt::format("\n{}.\n\n{}", kTimingScope, text);
  const ordered_json problems = lines("plugin_problems");
  if (!problems.empty()) text += "\n## Plugins that failed\n\n";
  for (const ordered_json& line : problems) text += fmt::format("- {}\n", line.get<std::string>());
  return text;
}

void merge_environments(const std::vector<ordered_json>& parts, ordered_json& environment) {
  ordered_json clocks = ordered_json::array();
  for (const ordered_json& part : parts) {
    if (!part.contains(kClock)) continue;
    if (part[kClock].is_array()) {
      clocks.insert(clocks.end(), part[kClock].begin(), part[kClock].end());
    } else {
      clocks.push_back(part[kClock]);
    }
  }
  if (!clocks.empty()) environment[kClock] = std::move(clocks);
  for (const char* key : {kText, "plugins", "plugin_problems"})
    for (const ordered_json& part : parts)
      for (const ordered_json& line : part.value(key, ordered_json::array()))
        add_line(environment, key, line.get<std::string>());
}

}  // namespace qs
