// SPDX-License-Identifier: MIT
#include "app/report/stats_file.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "app/measure/scene_facts.h"
#include "base/environment.h"
#include "base/json_of.h"
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
  if (stats.used_pairs) frame["used_pairs"] = *stats.used_pairs;
  if (record.result.psnr) frame["psnr_vs_reference"] = finite_or_null(*record.result.psnr);
  if (record.reference_psnr) frame["psnr_vs_picture"] = finite_or_null(*record.reference_psnr);
  if (!record.picture.empty()) frame["picture"] = record.picture;
  if (record.shot.number >= 0) frame["camera_index"] = record.shot.number;
  frame["camera"] = camera_json(record.shot.camera);
  return frame;
}

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

ordered_json scene_json(const Scene& scene) {
  return {{"file", scene.path.string()},
          {"hash", file_hash(scene.path)},
          {"format", scene.format},
          {"bytes", scene.file_bytes},
          {"gaussians", scene.cloud.size()},
          {"sh_degree", scene.cloud.sh_degree},
          {"antialiased", scene.cloud.antialiased}};
}

std::string format_stats(const Session& session, const std::vector<FrameRecord>& frames,
                         std::size_t view_count) {
  ordered_json json = {{"environment", environment_json(session)},
                       {"scene", scene_json(*session.scene)},
                       {"view_count", view_count},
                       {"frames", ordered_json::array()}};
  for (const FrameRecord& record : frames) json["frames"].push_back(frame_json(record));
  return json_file_text(json);
}

}  // namespace qs
