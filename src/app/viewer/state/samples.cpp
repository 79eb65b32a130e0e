// SPDX-License-Identifier: MIT
#include "app/viewer/state/samples.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/measure/statistics.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/mode_numbers.h"
#include "base/text.h"

namespace qs {
namespace {

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

constexpr std::size_t kMostShownTimes = 200;
constexpr std::size_t kKeptPairs = 8;  // of each mode and size

// The logarithms of the speed of `mode` relative to `other` by their pairs of this size, newest
// first.
std::vector<double> logs_of(const LiveTimes& live, CullMode mode, CullMode other, glm::ivec2 size) {
  std::vector<double> logs;
  for (auto pair = live.pairs.rbegin(); pair != live.pairs.rend(); ++pair) {
    if (pair->size != size) continue;
    if (pair->variant.mode == mode && pair->shown == other) logs.push_back(std::log(pair->speed));
    if (pair->variant.mode == other && pair->shown == mode) logs.push_back(-std::log(pair->speed));
  }
  return logs;
}

// The logarithms of a mode's speed relative to the mode in use: by their pairs, and by pairs with
// third modes, because the mode in use changes. A third mode with few pairs counts as little, so
// that one bad pair does not shift the row.
std::vector<double> speed_logs(const LiveTimes& live, CullMode mode, glm::ivec2 size) {
  std::vector<double> logs = logs_of(live, mode, live.used.mode, size);
  for (CullMode third = 1; third <= mode_count(); ++third) {
    if (third == mode || third == live.used.mode) continue;
    const std::vector<double> known = logs_of(live, third, live.used.mode, size);
    std::vector<double> more = logs_of(live, mode, third, size);
    more.resize(std::min(more.size(), known.size()));
    for (const double log : more) logs.push_back(log + median(known));
  }
  return logs;
}

// Begins again for another pipeline or backend.
void use(LiveTimes& live, const Variant& variant) {
  if (live.used.pipeline != variant.pipeline || live.used.backend != variant.backend)
    live = {variant, {}, {}};
  live.used = variant;
}

// The median time of the last mode's pictures of this size, of the last second or of the view at
// rest.
double used_ms(const LiveTimes& live) {
  const ShownTime& last = live.shown.back();
  std::vector<double> times;
  for (const ShownTime& shown : live.shown) {
    const bool together =
        last.at - shown.at <= kLiveSeconds || shown.view_version == last.view_version;
    if (shown.mode == last.mode && shown.size == last.size && together) times.push_back(shown.ms);
  }
  return median(times);
}

}  // namespace

std::optional<LiveRate> live_rate(const Viewer& viewer, CullMode mode, std::size_t fewest) {
  const LiveTimes& live = viewer.live;
  const Variant& used = live.used;
  if (live.shown.empty() || live.shown.back().view_version != viewer.shown.view_version ||
      used.pipeline != viewer.settings.pipeline || used.backend != viewer.backend)
    return std::nullopt;
  const ShownTime& last = live.shown.back();
  const double fps = 1000 / used_ms(live);
  if (mode == used.mode) return LiveRate{fps, 0};
  const std::vector<double> logs = speed_logs(live, mode, last.size);
  if (logs.empty()) return std::nullopt;
  const auto newest =
      std::ranges::find_if(live.pairs.rbegin(), live.pairs.rend(), [&](const PairedFrame& pair) {
        return pair.size == last.size && (pair.variant.mode == mode || pair.shown == mode);
      });
  const bool rests = newest->view_version == viewer.view_version && !viewer.moving();
  if (!rests && logs.size() < fewest) return std::nullopt;
  return LiveRate{fps * std::exp(median(logs)), rests ? 0 : viewer.now - newest->at};
}

std::string live_text(const LiveRate& rate) {
  const std::string text = "~" + rough(rate.fps);
  return rate.age > kLiveSeconds ? fmt::format("{} ({:.0f} s)", text, rate.age) : text;
}

std::string count_text(const LiveCount& count) {
  return (count.frames_ago > 0 ? "~" : "") + grouped(count.tile_pairs);
}

glm::ivec2 size_of(const Camera& camera) { return {camera.width, camera.height}; }

Camera counted_camera(const Viewer& viewer) {
  return viewer.moving() ? viewer.camera : measured_camera(viewer);
}

std::optional<LiveCount> live_pairs(const Viewer& viewer, CullMode mode) {
  const ViewCounts& counts = viewer.counts;
  if (mode < 1 || static_cast<std::size_t>(mode) > counts.modes.size() ||
      counts.size != size_of(counted_camera(viewer)))  // before a resize, for example
    return std::nullopt;
  const bool exact = counts.view_version == viewer.shown.view_version;
  const int frames_ago = exact ? 0 : viewer.frames - counts.frame;
  if (frames_ago > kMostFramesAgo) return std::nullopt;
  const ModePairs& pairs = counts.modes[static_cast<std::size_t>(mode - 1)];
  return LiveCount{pairs.tile_pairs, pairs.visible, frames_ago};
}

bool shows_counts(const Viewer& viewer) {
  const bool table = viewer.panels.hud && viewer.panels.all;
  return viewer.scene && !viewer.remote && (table || viewer.mode_switch || viewer.shows_badge);
}

bool counts_are_current(const Viewer& viewer) {
  return viewer.counts.view_version == viewer.view_version &&
         viewer.counts.size == size_of(counted_camera(viewer));
}

glm::ivec2 drawn_size(const ShownFrame& frame) {
  return glm::max(size_of(frame.camera) / frame.divisor, glm::ivec2(1));
}

std::string size_text(int divisor) { return divisor > 1 ? fmt::format(" at 1/{}", divisor) : ""; }

std::optional<FullSizePairs> full_size_pairs(const Viewer& viewer) {
  const ShownFrame& shown = viewer.shown;
  if (shown.divisor == 1) return FullSizePairs{shown.stats.tile_pairs, true};
  const std::optional<LiveCount> live = live_pairs(viewer, shown.mode);
  if (live && live->frames_ago == 0 && viewer.counts.size == size_of(viewer.camera))
    return FullSizePairs{live->tile_pairs, true};
  const auto growth = viewer.pair_growth.factors.find(shown.divisor);
  if (growth == viewer.pair_growth.factors.end()) return std::nullopt;
  const double pairs = growth->second * static_cast<double>(shown.stats.tile_pairs);
  return FullSizePairs{static_cast<std::uint64_t>(std::round(rounded(pairs))), false};
}

bool shows_colors_alone(const ShownFrame& frame) {
  return !frame.heatmap && !frame.values && !frame.other && !frame.grid;
}

void action::frame_paired(Viewer& v, const PairedFrame& pair) {
  use(v.live, {pair.shown, pair.variant.pipeline, pair.variant.backend});
  std::deque<PairedFrame>& pairs = v.live.pairs;
  pairs.push_back(pair);
  pairs.back().at = v.now;
  const auto is_like = [&](const PairedFrame& other) {
    return other.variant.mode == pair.variant.mode && other.size == pair.size;
  };
  if (static_cast<std::size_t>(std::ranges::count_if(pairs, is_like)) > kKeptPairs)
    pairs.erase(std::ranges::find_if(pairs, is_like));
}

void action::learn_from_frame(Viewer& v, const ShownFrame& frame) {
  if (frame.grid) return;
  if (frame.stats.is_occluded) return;  // not the time and the pairs of its mode
  learn_growth(v.pair_growth, v.shown, frame);
  if (!shows_colors_alone(frame) || frame.stats.frame_ms <= 0) return;
  use(v.live, {frame.mode, v.settings.pipeline, v.backend});
  std::deque<ShownTime>& shown = v.live.shown;
  shown.push_back({frame.mode, static_cast<double>(frame.stats.frame_ms), drawn_size(frame),
                   frame.view_version, v.now});
  if (shown.size() > kMostShownTimes) shown.pop_front();
}

void action::forget_live_times(Viewer& v) {
  v.live = {};
  v.pair_growth = {};
}

}  // namespace qs
