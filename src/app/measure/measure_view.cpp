// SPDX-License-Identifier: MIT
#include "app/measure/measure_view.h"

#include <algorithm>

#include "app/measure/statistics.h"

namespace qs {
namespace {

constexpr int kMarkedFrames = 20;  ///< at most, of the marked pass

BenchRow make_row(const Session& session, const Camera& camera, const ModeResult& result,
                  const std::vector<double>& frame_ms) {
  const RenderStats& stats = result.stats;
  const Summary summary = summarise(frame_ms);
  BenchRow row;
  row.mode = mode_name(result.mode);
  row.pipeline = pipeline_name(session);
  row.backend = kBackendNames[static_cast<int>(session.backend)];
  row.width = camera.width;
  row.height = camera.height;
  row.gaussians = stats.gaussians;
  row.visible = stats.visible;
  row.pairs = stats.tile_pairs;
  row.pairs_per_visible = pairs_per_visible(stats);
  row.max_tile = stats.max_pairs_in_a_tile;
  row.ms_median = summary.median;
  row.ms_p05 = summary.p05;
  row.ms_p95 = summary.p95;
  row.fps_median = summary.median > 0 ? 1000 / summary.median : 0;
  row.ms_mean = summary.mean;
  row.drift = summary.drift;
  row.frame_ms = static_cast<double>(result.marked_frame_ms);
  double* stages[kStageCount] = {&row.preprocess_ms, &row.bin_ms, &row.sort_ms, &row.blend_ms};
  for (int stage = 0; stage < kStageCount; ++stage)
    *stages[stage] = static_cast<double>(stats.stage_ms[stage]);
  return row;
}

/// Renders an extra frame, so that counting does not slow the timed frames down.
void count_false_positives(Session& session, const Camera& camera, CullMode mode,
                           const Target& target, std::stop_token stop, BenchRow& row) {
  RenderSettings settings = session.settings;
  settings.mode = mode;
  Outputs outputs;
  outputs.color = false;
  outputs.used = true;
  const RenderStats& stats =
      session.renderer->render(camera, settings, outputs, target, std::move(stop)).stats;
  if (!stats.used_pairs) return;
  row.false_positives = stats.tile_pairs - *stats.used_pairs;
  row.false_positive_share = stats.tile_pairs == 0 ? 0
                                                   : static_cast<double>(*row.false_positives) /
                                                         static_cast<double>(stats.tile_pairs);
}

// Images stay in the backend's own memory.
Target bench_target(Backend backend) {
  return backend == Backend::cpu ? Target(HostImage{}) : Target(DeviceImage{});
}

}  // namespace

std::vector<BenchRow> measure_view(Session& session, const std::vector<CullMode>& modes,
                                   const Camera& camera, const ViewPlan& plan,
                                   const Progress& progress) {
  MeasurePlan measuring{modes, plan.warmup, plan.frames, bench_target(session.backend),
                        {},    plan.clock};
  std::vector<std::vector<double>> frame_ms(modes.size()), medians(modes.size());
  std::vector<ModeResult> results;
  for (int round = 0; round < plan.rounds; ++round) {
    measuring.progress = {
        [&](float done) {
          progress.update((static_cast<float>(round) + done) / static_cast<float>(plan.rounds));
        },
        progress.stop};
    results = measure_modes(*session.renderer, camera, session.settings, {}, measuring,
                            [](CullMode, const Frame&) {});
    for (std::size_t i = 0; i < modes.size(); ++i) {
      frame_ms[i].insert(frame_ms[i].end(), results[i].frame_ms.begin(), results[i].frame_ms.end());
      medians[i].push_back(median(results[i].frame_ms));
    }
  }
  std::vector<BenchRow> rows;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    // The CPU always measures stages, at no cost.
    results[i].marked_frame_ms = results[i].stats.frame_ms;
    if (plan.details && session.backend != Backend::cpu)
      mark_stages(*session.renderer, camera, session.settings, results[i],
                  std::min(plan.frames, kMarkedFrames), measuring.target, progress.stop);
    rows.push_back(make_row(session, camera, results[i], frame_ms[i]));
    rows.back().round_ms = medians[i];
    if (plan.rounds > 1) rows.back().round_spread = relative_spread(medians[i]);
    if (plan.details) {
      count_false_positives(session, camera, modes[i], measuring.target, progress.stop,
                            rows.back());
    }
  }
  return rows;
}

}  // namespace qs
