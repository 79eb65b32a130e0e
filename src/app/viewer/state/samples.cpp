// SPDX-License-Identifier: MIT
#include "app/viewer/state/samples.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/mode_numbers.h"

namespace qs {
namespace {

// The value of one step in the second significant digit. `value` > 0.
double second_digit(double value) { return std::pow(10.0, std::floor(std::log10(value)) - 1); }

double rounded(double value) {
  if (value <= 0) return 0;
  const double unit = second_digit(value);
  return std::round(value / unit) * unit;
}

// True if two frames of a moving camera show nearly the same Gaussians.
bool are_near(const RenderStats& a, const RenderStats& b) {
  constexpr double kMostChange = 0.1;
  const double difference = static_cast<double>(a.visible) - b.visible;
  return a.visible > 0 && std::abs(difference) <= kMostChange * a.visible;
}

// A view that comes to rest is drawn reduced first and then at full size, which gives the factors.
// The first frame of a size in a motion gives a rough factor, by the frame of another size before
// it.
void learn_growth(PairGrowth& growth, const ShownFrame& before, const ShownFrame& frame) {
  if (growth.view_version != frame.view_version || growth.mode != frame.mode)
    growth.reduced.clear();
  growth.view_version = frame.view_version;
  growth.mode = frame.mode;
  const auto pairs = static_cast<double>(frame.stats.tile_pairs);
  if (frame.divisor > 1) {
    growth.reduced[frame.divisor] = pairs;
    const auto known = growth.factors.find(before.divisor);
    if (before.divisor != frame.divisor && known != growth.factors.end() &&
        before.mode == frame.mode && pairs > 0 && are_near(before.stats, frame.stats))
      growth.factors.try_emplace(
          frame.divisor, known->second * static_cast<double>(before.stats.tile_pairs) / pairs);
    return;
  }
  for (const auto& [divisor, reduced] : growth.reduced)
    if (reduced > 0) growth.factors[divisor] = pairs / reduced;
}

}  // namespace

std::optional<LiveCount> live_pairs(const Viewer& viewer, CullMode mode) {
  const ViewCounts& counts = viewer.counts;
  if (mode < 1 || static_cast<std::size_t>(mode) > counts.modes.size()) return std::nullopt;
  const bool exact = counts.view_version == viewer.shown.view_version;
  const int frames_ago = exact ? 0 : viewer.frames - counts.frame;
  if (frames_ago > kMostFramesAgo) return std::nullopt;
  const ModePairs& pairs = counts.modes[static_cast<std::size_t>(mode - 1)];
  return LiveCount{pairs.tile_pairs, pairs.visible, frames_ago};
}

bool shows_counts(const Viewer& viewer) {
  return viewer.scene && !viewer.remote && viewer.panels.hud && viewer.panels.all;
}

bool counts_are_current(const Viewer& viewer) {
  return viewer.counts.view_version == viewer.view_version;
}

const ModeSample* sample_of(const Viewer& viewer, CullMode mode) {
  const auto found = viewer.samples.find(mode);
  if (found == viewer.samples.end()) return nullptr;
  const ModeSample& sample = found->second;
  const Variant wanted{mode, viewer.settings.pipeline, viewer.backend};
  if (sample.variant != wanted) return nullptr;
  const bool of_this_view = sample.view_version == viewer.view_version;
  return of_this_view || viewer.frames - sample.frame <= kMostFramesOfSample ? &sample : nullptr;
}

double fps_of(const ModeSample& sample) { return sample.frame_ms > 0 ? 1000 / sample.frame_ms : 0; }

std::string sample_text(const ModeSample& sample) {
  return "~" + rough(fps_of(sample)) + size_text(sample.divisor);
}

std::string size_text(int divisor) { return divisor > 1 ? fmt::format(" at 1/{}", divisor) : ""; }

std::string rough(double value) {
  if (value <= 0) return "0";
  const double shown = rounded(value);
  return significant(shown, second_digit(shown));
}

std::optional<FullSizePairs> full_size_pairs(const Viewer& viewer) {
  const ShownFrame& shown = viewer.shown;
  if (shown.divisor == 1) return FullSizePairs{shown.stats.tile_pairs, true};
  const Camera measured = measured_camera(viewer);
  const std::optional<LiveCount> live = live_pairs(viewer, shown.mode);
  if (live && live->frames_ago == 0 && measured.width == viewer.camera.width &&
      measured.height == viewer.camera.height)
    return FullSizePairs{live->tile_pairs, true};
  const auto growth = viewer.pair_growth.factors.find(shown.divisor);
  if (growth == viewer.pair_growth.factors.end()) return std::nullopt;
  const double pairs = growth->second * static_cast<double>(shown.stats.tile_pairs);
  return FullSizePairs{static_cast<std::uint64_t>(std::round(rounded(pairs))), false};
}

bool shows_colors_alone(const ShownFrame& frame) {
  return !frame.heatmap && !frame.values && !frame.other && !frame.grid;
}

void action::mode_sampled(Viewer& v, const ModeSample& sample) {
  ModeSample& kept = v.samples[sample.variant.mode];
  kept = sample;
  kept.frame = v.frames;
}

void action::learn_from_frame(Viewer& v, const ShownFrame& frame) {
  if (frame.grid) return;
  learn_growth(v.pair_growth, v.shown, frame);
  if (!shows_colors_alone(frame) || frame.stats.frame_ms <= 0) return;
  const Variant variant{frame.mode, v.settings.pipeline, v.backend};
  mode_sampled(v, {variant, static_cast<double>(frame.stats.frame_ms), frame.divisor,
                   frame.view_version, v.frames});
}

void action::forget_samples(Viewer& v) {
  v.samples.clear();
  v.pair_growth = {};
}

}  // namespace qs
