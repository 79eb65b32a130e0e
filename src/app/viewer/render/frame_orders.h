// SPDX-License-Identifier: MIT
//
// What the window orders from the render thread: the frame of the view, smaller while the view
// moves and the CPU draws, and once it rests the numbers of all modes.
#pragma once

#include "app/viewer/render/render_thread.h"

namespace qs {

/// The view as it is, in full size.
FrameOrder order_of(const Viewer& viewer);

/// The table of modes is measured for views that are drawn whole, when somebody can see it.
bool numbers_are_missing(const Viewer& viewer);

class FrameOrders {
 public:
  /// Orders what is not on its way yet. `window_rests`: it draws nothing that would disturb a
  /// measurement.
  void place(const Viewer& viewer, RenderThread& render, bool window_rests);

  /// How long frames take follows from the last one.
  void learn(const FrameReply& reply);

  /// Was the picture as it is now ordered?
  bool are_placed(const Viewer& viewer) const { return viewer.version == version_; }

 private:
  int version_ = -1, divisor_ = 1;  // of the last order
  double ms_per_megapixel_ = 0;
};

}  // namespace qs
