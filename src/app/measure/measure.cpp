// SPDX-License-Identifier: MIT
#include "app/measure/measure.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/measure/paired_ratios.h"
#include "app/measure/statistics.h"
#include "base/error.h"
#include "base/text.h"

namespace qs {
namespace {

// The ratio of the times of frames of the same round; "-" for too few of them.
std::string ratio_of_frames(const ModeResult& base, const ModeResult& row) {
  const std::optional<Ratio> ratio = ratio_of_times(base.frame_ms, row.frame_ms);
  if (!ratio || std::min(base.frame_ms.size(), row.frame_ms.size()) < kFewestFrames) return "-";
  return ratio_text(&base == &row ? Ratio() : *ratio);
}

}  // namespace

std::vector<ModeResult> measure_modes(Renderer& renderer, const Camera& camera,
                                      RenderSettings settings, const Outputs& outputs,
                                      const MeasurePlan& plan,
                                      const std::function<void(CullMode, const Frame&)>& visit) {
  const std::size_t modes = plan.modes.size(), turns = modes + plan.guests.size();
  std::vector<std::vector<RenderStats>> measured(turns);
  std::vector<ModeResult> results(turns);
  for (std::size_t i = 0; i < modes; ++i) results[i].mode = plan.modes[i];
  // Render the modes and the guests in turns.
  TurnOrder own_order;
  TurnOrder& order = plan.order != nullptr ? *plan.order : own_order;
  const float all_turns = static_cast<float>(turns) * static_cast<float>(plan.warmup + plan.frames);
  float done = 0;
  for (int round = -plan.warmup; round < plan.frames; ++round) {
    for (const std::size_t i : order.next(turns)) {
      plan.progress.update(done++ / all_turns);
      settings.mode = results[i].mode;
      if (!results[i].problem.empty()) continue;
      const bool own = i < modes;
      try {
        const Frame& frame =
            (own ? renderer : *plan.guests[i - modes].renderer)
                .render(camera, settings, outputs, own ? plan.target : Target(DeviceImage{}),
                        plan.progress.stop);
        if (round >= 0) measured[i].push_back(frame.stats);
        if (round >= 0 && plan.clock != nullptr) plan.clock->sample();
        if (round == -plan.warmup && own) visit(settings.mode, frame);
      } catch (const Error& error) {
        if (own) throw;
        results[i].problem = error.what();
      }
    }
  }
  // Summarise.
  for (std::size_t i = 0; i < turns; ++i) {
    if (!results[i].problem.empty()) continue;
    for (const RenderStats& stats : measured[i])
      results[i].frame_ms.push_back(static_cast<double>(stats.frame_ms));
    const auto middle = measured[i].begin() + static_cast<std::ptrdiff_t>(measured[i].size() / 2);
    std::ranges::nth_element(measured[i], middle, {}, &RenderStats::frame_ms);
    results[i].stats = *middle;
  }
  return results;
}

void mark_stages(Renderer& renderer, const Camera& camera, RenderSettings settings,
                 const MarkedPlan& plan, ModeResult& result) {
  settings.mode = result.mode;
  const Outputs outputs{.stage_times = true};
  std::vector<double> frame_ms, stage_ms[kStageCount];
  for (int i = 0; i < plan.frames; ++i) {
    const RenderStats& marked =
        renderer.render(camera, settings, outputs, plan.target, plan.stop).stats;
    frame_ms.push_back(static_cast<double>(marked.frame_ms));
    for (int stage = 0; stage < kStageCount; ++stage)
      stage_ms[stage].push_back(static_cast<double>(marked.stage_ms[stage]));
  }
  result.marked_frame_ms = static_cast<float>(median(frame_ms));
  for (int stage = 0; stage < kStageCount; ++stage)
    result.stats.stage_ms[stage] = static_cast<float>(median(stage_ms[stage]));
}

double pairs_per_visible(const RenderStats& stats) {
  return stats.visible == 0 ? 0 : static_cast<double>(stats.tile_pairs) / stats.visible;
}

std::string format_mode_table(std::span<const ModeResult> results) {
  const bool with_psnr =
      std::ranges::any_of(results, [](const ModeResult& row) { return row.psnr.has_value(); });
  const auto base = std::ranges::find(results, find_culler(kUsualBaseline), &ModeResult::mode);
  std::string text =
      fmt::format("{:13}  {:>18}  {:>7}  {:>12}  {:>13}  {:>18}", "mode", "ms", "FPS", "pairs",
                  "pairs/visible", fmt::format("vs {}", kUsualBaseline));
  if (with_psnr) text += fmt::format("  {:>7}", "PSNR dB");
  text += "  what it is\n";
  for (const ModeResult& row : results) {
    const RenderStats& s = row.stats;
    const double ms = row.frame_ms.empty() ? 0 : median(row.frame_ms);
    const std::optional<double> spread = quartile_spread(row.frame_ms);
    const CullerRow& culler = row_of(row.mode);
    text += fmt::format("{:13}  {:>18}  {:>7}  {:>12}  {:13.2f}  {:>18}", culler.name,
                        time_text(ms, spread) + (is_noisy_spread(spread, ms) ? " noisy" : ""),
                        rate_text(ms, spread), grouped(s.tile_pairs), pairs_per_visible(s),
                        base == results.end() ? "-" : ratio_of_frames(*base, row));
    if (with_psnr) text += fmt::format("  {:>7}", row.psnr ? decibels(*row.psnr) : "-");
    text += fmt::format("  {}\n", culler.summary);
  }
  return text;
}

}  // namespace qs
