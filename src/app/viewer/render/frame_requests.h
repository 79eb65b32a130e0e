// SPDX-License-Identifier: MIT
//
// Decides the next work of the render thread for the Viewer: draw a frame (reduced while the camera
// moves and the CPU draws, then refined in steps), and once the view is still, measure all modes.
#pragma once

#include "app/viewer/render/render_thread.h"
#include "app/viewer/render/resolution.h"
#include "raster/api/renderer.h"

namespace qs {

/// The view at full size, with shown_settings().
FrameRequest full_frame(const Viewer& viewer);

/// True if the table of modes is visible, is out of date and can be measured: the window draws on
/// demand and shows the full-size frame.
bool numbers_are_missing(const Viewer& viewer);

/// True if frames of other modes should follow the picture of a moving camera: FrameRequest::pairs.
bool wants_pairs(const Viewer& viewer, const FrameRequest& request);

/// True if the picture may leave out hidden Gaussians, see RenderSettings::occlusion. The table of
/// modes is of frames with all Gaussians, and the picture is one of them.
bool may_occlude(const Viewer& viewer, const FrameRequest& request);

/// True if numbers_are_missing(), or if the table is not precise enough yet.
bool numbers_are_wanted(const Viewer& viewer);

/// True if the table of modes is visible and the view at rest in the window was not counted.
bool counts_are_missing(const Viewer& viewer);

/// True if nothing moves and the window shows the final frame, counts and numbers of the view.
bool is_settled(const Viewer& viewer);

/// The cost of all renderings of a frame.
FrameCost cost_of(const ShownFrame& shown);

/// Decides which frames of a moving camera count the pairs of all modes: so few that counting takes
/// at most a tenth of the time of drawing, but at least every kMostFramesAgo-th frame.
class CountingPace {
 public:
  /// A frame was drawn. `counted`: it counted the pairs.
  void learn(const RenderStats& stats, bool counted);

  /// True if the next frame counts.
  bool counts_next() const { return uncounted_ + 1 >= period_; }

 private:
  int period_ = 1;     // every n-th frame counts
  int uncounted_ = 0;  // frames since the last count
};

class FrameRequests {
 public:
  /// Requests the missing frame or numbers. `window_rests`: the window will not draw now. Drawing
  /// would disturb a measurement, so modes are measured only then.
  void update(const Viewer& viewer, RenderThread& render, bool window_rests);

  /// Estimates the time of the next frame from the time of this frame.
  void learn(const RenderedFrame& frame);

  /// True if the newest picture was requested.
  bool are_up_to_date(const Viewer& viewer) const { return viewer.version == version_; }

 private:
  int next_divisor(const Viewer& viewer) const;
  bool next_counts(const Viewer& viewer) const;

  std::shared_ptr<const LensView> quick(const std::shared_ptr<const LensView>& lens);

  int version_ = -1, divisor_ = 1;                     // the last request's
  bool is_quick_ = false;                              // it has few faces
  std::shared_ptr<const LensView> lens_, quick_lens_;  // the last lens, with its and with few faces
  int counted_version_ = -1;    // Viewer::view_version of the last request that counts
  glm::ivec2 counted_size_{0};  // of that view, pixels
  Resolution resolution_;
  CountingPace counting_pace_;
};

}  // namespace qs
