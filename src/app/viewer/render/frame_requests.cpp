// SPDX-License-Identifier: MIT
#include "app/viewer/render/frame_requests.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "app/viewer/render/host_frames.h"
#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/panel_text.h"
#include "app/viewer/state/samples.h"
#include "app/viewer/state/training_actions.h"
#include "io/camera/lens_views.h"

namespace qs {
namespace {

bool draws_on_the_cpu(const Viewer& viewer) {
  return viewer.backend == Backend::cpu ||
         (viewer.panels.split && !viewer.shows_grid && !viewer.beside &&
          viewer.split.other.backend == Backend::cpu);
}

// A frame of a moving camera may have the scale of an earlier view.
bool has_old_scale(const Viewer& viewer) {
  return viewer.shown.heatmap && viewer.shown.scale_version != viewer.view_version;
}

bool shows_full_frame(const Viewer& viewer) {
  return viewer.shown.version == viewer.version && viewer.shown.divisor == 1 &&
         !has_old_scale(viewer);
}

bool can_measure(const Viewer& viewer) {
  return shows_full_frame(viewer) && viewer.on_demand && !viewer.remote && !is_training(viewer) &&
         !viewer.zoom.running && (viewer.shows_grid || (viewer.panels.hud && viewer.panels.all));
}

bool shows_colors_alone(const FrameRequest& request) {
  return !request.heatmap && !request.other && !request.grid &&
         request.quantity == Quantity::color && request.settings.mode != kReferenceMode &&
         !request.tint;
}

}  // namespace

bool wants_pairs(const Viewer& viewer, const FrameRequest& request) {
  return viewer.moving() && shows_counts(viewer) && shows_colors_alone(request) &&
         !is_training(viewer);
}

bool may_occlude(const Viewer& viewer, const FrameRequest& request) {
  return viewer.occlusion && shows_colors_alone(request) && !shows_counts(viewer);
}

FrameRequest full_frame(const Viewer& viewer) {
  FrameRequest request{.camera = viewer.camera,
                       .settings = shown_settings(viewer),
                       .heatmap = viewer.heatmap,
                       .baseline = viewer.baseline,
                       .heat_maximum = viewer.heat_view.maximum,
                       .grid = viewer.shows_grid,
                       .heat_style = viewer.heat_view.style,
                       .version = viewer.version,
                       .view_version = viewer.view_version,
                       .picture = viewer.version - viewer.mode_changes};
  if (viewer.panels.split && !viewer.shows_grid) {
    request.beside = viewer.beside.has_value();
    request.other = request.beside ? viewer.variant() : viewer.split.other;
  } else if (!viewer.shows_grid) {
    request.quantity = viewer.quantity;
  }
  if (viewer.crop.marks && !has_faces(request.settings.lens)) request.tint = viewer.crop.tint;
  return request;
}

bool numbers_are_missing(const Viewer& viewer) {
  return can_measure(viewer) && !numbers_are_current(viewer);
}

bool numbers_are_wanted(const Viewer& viewer) {
  return can_measure(viewer) && !numbers_suffice(viewer);
}

bool counts_are_missing(const Viewer& viewer) {
  return shows_counts(viewer) && !viewer.shows_grid && shows_full_frame(viewer) &&
         !viewer.moving() && !is_training(viewer) && !viewer.zoom.running &&
         !counts_are_current(viewer);
}

bool is_settled(const Viewer& viewer) {
  if (viewer.loading || viewer.crop.busy || is_training(viewer)) return false;
  if (viewer.levels && viewer.levels->stream.reading > 0) return false;
  if (!viewer.scene) return true;
  return shows_full_frame(viewer) && !numbers_are_missing(viewer) && !counts_are_missing(viewer) &&
         !viewer.measuring && !viewer.moving() && !viewer.playback.running && !viewer.zoom.running;
}

int FrameRequests::next_divisor(const Viewer& viewer) const {
  const bool reduces = draws_on_the_cpu(viewer) && viewer.reduce_when_moving;
  if (reduces && viewer.moving()) return resolution_.divisor();
  if (!are_up_to_date(viewer)) return 1;
  // The requested frame is refined once the window shows it.
  return viewer.shown.version == viewer.version ? refined(viewer.shown.divisor) : divisor_;
}

// The mode does not change the counts, so a view is counted once. A view at rest is always counted.
bool FrameRequests::next_counts(const Viewer& viewer) const {
  if (!shows_counts(viewer) || counts_are_current(viewer)) return false;
  return counting_pace_.counts_next() || !(viewer.moving() || is_training(viewer));
}

void FrameRequests::update(const Viewer& viewer, RenderThread& render, bool window_rests) {
  if (!viewer.scene || viewer.zoom.running || !may_draw(viewer)) return;
  const int divisor = next_divisor(viewer);
  const bool continuous = !viewer.on_demand && !render.busy();
  const bool rescales = viewer.shown.version == viewer.version && viewer.shown.divisor == 1 &&
                        has_old_scale(viewer) && !viewer.moving() && !render.busy();
  // For example because the table was opened.
  const Camera counted = counted_camera(viewer);
  const bool sharpens = is_quick_ && !viewer.moving() && divisor == 1 && !render.busy();
  const bool uncounted = counts_are_missing(viewer) && (counted_version_ != viewer.view_version ||
                                                        counted_size_ != size_of(counted));
  if (!are_up_to_date(viewer) || divisor < divisor_ || continuous || rescales || sharpens ||
      uncounted) {
    FrameRequest request = full_frame(viewer);
    // Other faces have other counts.
    is_quick_ =
        has_faces(request.settings.lens) && !request.heatmap && (viewer.moving() || divisor > 1);
    if (is_quick_) request.settings.lens = quick(request.settings.lens);
    request.divisor = divisor;
    request.moving = viewer.moving();
    request.pairs = wants_pairs(viewer, request);
    request.settings.occlusion = may_occlude(viewer, request);
    if (next_counts(viewer)) {
      request.counted = CountedView{counted, request.settings};
      counted_version_ = viewer.view_version;
      counted_size_ = size_of(counted);
    }
    render.request(std::move(request));
    version_ = viewer.version;
    divisor_ = divisor;
  }
  const bool still = viewer.still() && !viewer.playback.running;
  if (still && numbers_are_wanted(viewer) && window_rests && !render.busy())
    render.request(NumbersRequest{measured_camera(viewer), full_frame(viewer).settings,
                                  viewer.view_version, numbers_are_current(viewer)});
}

// The same lens by few faces. One object per lens, because its map is kept for it.
std::shared_ptr<const LensView> FrameRequests::quick(const std::shared_ptr<const LensView>& lens) {
  if (lens_ != lens) {
    LensView few = *lens;
    few.faces = kFewFaces;
    lens_ = lens;
    quick_lens_ = std::make_shared<const LensView>(std::move(few));
  }
  return quick_lens_;
}

FrameCost cost_of(const ShownFrame& shown) {
  FrameCost sum;
  const auto add = [&](const RenderStats& stats) {
    const FrameCost one = cost_of(stats);
    sum = {sum.ms + one.ms, sum.pixels_ms + one.pixels_ms};
  };
  if (shown.grid) {
    for (const RenderStats& stats : shown.grid->stats) add(stats);
    return sum;
  }
  add(shown.stats);
  if (shown.other) add(shown.other->stats);
  return sum;
}

void FrameRequests::learn(const RenderedFrame& frame) {
  resolution_.learn(frame.shown.divisor, cost_of(frame.shown));
  counting_pace_.learn(frame.shown.stats, !frame.shown.mode_pairs.empty());
}

void CountingPace::learn(const RenderStats& stats, bool counted) {
  constexpr float kMostShare = 0.1f;  // share of the time of drawing
  if (!counted) {
    ++uncounted_;
    return;
  }
  uncounted_ = 0;
  if (stats.count_ms <= 0) {  // not measured: on a GPU it takes 3 to 16 % of a frame
    period_ = 2;
    return;
  }
  const float affordable = kMostShare * stats.frame_ms;
  const float period = affordable > 0 ? std::ceil(stats.count_ms / affordable) : 1;
  period_ = static_cast<int>(std::clamp(period, 1.0f, static_cast<float>(kMostFramesAgo)));
}

}  // namespace qs
