// SPDX-License-Identifier: MIT
//
// Decides what the render thread should do for the Viewer: draw a frame (reduced while the camera
// moves and the CPU draws, then refined in steps), and once the view is still, measure all modes.
#pragma once

#include "app/viewer/render/render_thread.h"
#include "app/viewer/render/resolution.h"

namespace qs {

/// The view at full size.
FrameRequest full_frame(const Viewer& viewer);

/// True if the table of modes is visible, is out of date and can be measured: the window draws on
/// demand and shows the full-size frame.
bool numbers_are_missing(const Viewer& viewer);

/// The same, and also if the table is not precise enough yet.
bool numbers_are_wanted(const Viewer& viewer);

/// True if the window shows the final frame and numbers of the view and nothing moves.
bool is_settled(const Viewer& viewer);

class FrameRequests {
 public:
  /// Requests what is missing. `window_rests`: the window will not draw, which would disturb a
  /// measurement.
  void update(const Viewer& viewer, RenderThread& render, bool window_rests);

  /// Learns from a frame how long the next one will take.
  void learn(const RenderedFrame& frame);

  /// True if the newest picture was requested.
  bool are_up_to_date(const Viewer& viewer) const { return viewer.version == version_; }

 private:
  int next_divisor(const Viewer& viewer) const;

  int version_ = -1, divisor_ = 1;  // of the last request
  Resolution resolution_;
};

}  // namespace qs
