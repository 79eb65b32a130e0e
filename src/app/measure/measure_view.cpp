// SPDX-License-Identifier: MIT
#include "app/measure/measure_view.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "app/measure/statistics.h"
#include "app/session/alterations.h"
#include "base/error.h"
#include "base/progress_bar.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

// Images stay in the backend's own memory.
Target bench_target(Backend backend) {
  return backend == Backend::cpu ? Target(HostImage{}) : Target(DeviceImage{});
}

// The arguments of measure_view().
struct MeasuredView {
  Session& session;
  const std::vector<CullMode>& modes;
  const Camera& camera;
  const ViewPlan& plan;
  const Progress& progress;
};

BenchRow make_row(const Session& session, const Camera& camera, const ModeResult& result,
                  const std::vector<double>& frame_ms) {
  const RenderStats& stats = result.stats;
  BenchRow row;
  row.mode = mode_name(result.mode);
  row.pipeline = pipeline_name(session.backend, stats.pipeline);
  row.backend = kBackendNames[static_cast<int>(session.backend)];
  row.width = camera.width;
  row.height = camera.height;
  row.gaussians = stats.gaussians;
  row.visible = stats.visible;
  row.pairs = stats.tile_pairs;
  row.pairs_per_visible = pairs_per_visible(stats);
  row.max_tile = stats.max_pairs_in_a_tile;
  row.sort_bytes = stats.sort_bytes;
  set_times(row, frame_ms);
  row.frame_ms = static_cast<double>(result.marked_frame_ms);
  double* stages[kStageCount] = {&row.preprocess_ms, &row.bin_ms, &row.sort_ms, &row.blend_ms};
  for (int stage = 0; stage < kStageCount; ++stage)
    *stages[stage] = static_cast<double>(stats.stage_ms[stage]);
  return row;
}

/// Renders an extra frame with whole lists, so that counting does not slow the timed frames down,
/// and a frame that left out hidden Gaussians has the pairs of its mode.
void count_pairs(const MeasuredView& view, CullMode mode, const Target& target, BenchRow& row) {
  RenderSettings settings = view.session.settings;
  settings.mode = mode;
  const Outputs outputs{.color = false, .used = true};
  const RenderStats& stats =
      view.session.renderer->render(view.camera, settings, outputs, target, view.progress.stop)
          .stats;
  row.visible = stats.visible;
  row.pairs = stats.tile_pairs;
  row.pairs_per_visible = pairs_per_visible(stats);
  row.max_tile = stats.max_pairs_in_a_tile;
  if (!stats.used_pairs) return;
  row.false_positives = stats.tile_pairs - *stats.used_pairs;
  row.false_positive_share = stats.tile_pairs == 0 ? 0
                                                   : static_cast<double>(*row.false_positives) /
                                                         static_cast<double>(stats.tile_pairs);
}

// A mode or a guest, over all rounds.
struct Measured {
  ModeResult result;  // result of the last round
  std::vector<double> frame_ms, medians;
};

// Measures all modes and guests once. A guest with a problem is left out and keeps its first
// problem.
void measure_round(const MeasuredView& view, int round, TurnOrder& order,
                   std::vector<Measured>& all) {
  const auto& [session, modes, camera, plan, progress] = view;
  std::vector<std::size_t> present;
  std::vector<Guest> guests;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i].result.problem.empty()) continue;
    present.push_back(i);
    if (i >= modes.size()) guests.push_back(plan.guests[i - modes.size()]);
  }
  const MeasurePlan measuring{
      modes,
      plan.warmup,
      plan.frames,
      bench_target(session.backend),
      step_of(progress, static_cast<std::size_t>(round), static_cast<std::size_t>(plan.rounds)),
      plan.clock,
      guests,
      &order};
  std::vector<ModeResult> results = measure_modes(*session.renderer, camera, session.settings, {},
                                                  measuring, [](CullMode, const Frame&) {});
  for (std::size_t i = 0; i < present.size(); ++i) {
    Measured& measured = all[present[i]];
    measured.result = std::move(results[i]);
    if (!measured.result.problem.empty()) continue;
    const std::vector<double>& frame_ms = measured.result.frame_ms;
    measured.frame_ms.insert(measured.frame_ms.end(), frame_ms.begin(), frame_ms.end());
    measured.medians.push_back(median(frame_ms));
  }
}

}  // namespace

std::vector<BenchRow> measure_view(Session& session, const std::vector<CullMode>& modes,
                                   const Camera& camera, const ViewPlan& plan,
                                   const Progress& progress) {
  const MeasuredView view{session, modes, camera, plan, progress};
  std::vector<Measured> all(modes.size() + plan.guests.size());
  TurnOrder order(plan.first_round);
  for (int round = 0; round < plan.rounds; ++round) measure_round(view, round, order, all);
  const std::string altered = alterations_of(session).text;
  std::vector<BenchRow> rows;
  for (std::size_t i = 0; i < all.size(); ++i) {
    ModeResult& result = all[i].result;
    const Guest* const guest = i < modes.size() ? nullptr : &plan.guests[i - modes.size()];
    const Target target = guest ? Target(DeviceImage{}) : bench_target(session.backend);
    result.marked_frame_ms = result.stats.frame_ms;
    // The CPU backend always measures stages, at no cost. Frames with stages list all Gaussians.
    const bool marks = guest || (session.backend != Backend::cpu && !result.stats.is_occluded);
    if (plan.details && result.problem.empty() && marks) {
      try {
        mark_stages(guest ? *guest->renderer : *session.renderer, camera, session.settings,
                    {std::min(plan.frames, kMarkedFrames), target, progress.stop}, result);
      } catch (const Error& error) {
        if (!guest) throw;
        result.problem = error.what();  // it loses its other results
      }
    }
    if (!result.problem.empty()) {
      if (plan.guest_failed) plan.guest_failed(*guest, result.problem);
      continue;
    }
    BenchRow& row = rows.emplace_back(make_row(session, camera, result, all[i].frame_ms));
    row.round_ms = all[i].medians;
    if (!altered.empty()) row.altered = altered;
    if (plan.rounds > 1) {
      row.round_spread = relative_spread(row.round_ms);
    } else {
      row.turn_ms = all[i].frame_ms;
    }
    if (guest) {
      row.mode = guest->name;
      row.backend = kPluginBackend;
    } else if (plan.details) {
      count_pairs(view, modes[i], target, row);
    }
  }
  return rows;
}

std::vector<std::vector<double>> paper_times(Session& session, const std::vector<CullMode>& modes,
                                             std::span<const Camera> views, int rounds,
                                             const Progress& progress) {
  constexpr std::size_t kWarmupViews = 5;
  std::vector<std::vector<double>> times(modes.size(), std::vector<double>(views.size()));
  if (views.empty()) return times;
  const Target target = bench_target(session.backend);
  const float runs = static_cast<float>(rounds) * static_cast<float>(modes.size());
  float done = 0;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t mode = 0; mode < modes.size(); ++mode) {
      progress.update(done++ / runs);
      RenderSettings settings = session.settings;
      settings.mode = modes[mode];
      const auto draw = [&](std::size_t view) {
        const Frame& frame =
            session.renderer->render(views[view], settings, {}, target, progress.stop);
        return static_cast<double>(frame.stats.frame_ms);
      };
      for (std::size_t i = 0; i < kWarmupViews; ++i) draw(i % views.size());
      for (std::size_t view = 0; view < views.size(); ++view)
        times[mode][view] += draw(view) / rounds;
    }
  }
  return times;
}

void judge_quality(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                   const Image& truth, ThreadPool& pool, BenchRow& row) {
  Image image = renderer.render(camera, settings).color;
  const Image& again = renderer.render(camera, settings).color;
  row.repeats = std::memcmp(image.values.data(), again.values.data(),
                            image.values.size() * sizeof(float)) == 0;
  row.psnr_vs_reference = psnr_8bit(image, truth);
  Image clamped_truth = truth;
  clamp_to_unit(image);
  clamp_to_unit(clamped_truth);
  row.ssim_vs_reference = ssim(image, clamped_truth, pool);
  row.flip_vs_reference = flip(clamped_truth, image, pool);
}

}  // namespace qs
