// SPDX-License-Identifier: MIT
//
// Decides when the window is drawn, and for which time the loop sleeps. On demand the window is
// drawn only while something changes, and as little as possible while the render thread measures,
// because drawing takes time from the measured GPU or CPU. While it draws continuously or the
// camera moves, the window waits for the next frame, so that every drawing shows a new picture; a
// slow frame does not stop the window. Reading a scene may need every core, so the loop pauses
// between drawings of its progress. It also pauses between drawings while a model is trained. While
// a zoom is recorded the window is drawn on demand only, because a drawing voids a step.
#pragma once

#include "app/viewer/state/viewer.h"

namespace qs {

/// The loop's own facts, which the Viewer lacks.
struct Surroundings {
  double now = 0;            ///< seconds, at least Viewer::now
  double last_event = -1e9;  ///< the window's last event, seconds
  bool render_busy = false;  ///< RenderThread::busy()
  bool has_pending = false;  ///< Input::busy(), a script plays or a frame is not requested yet
};

class Pacing {
 public:
  /// Notes a change that the user should see.
  void note_change(const Viewer& viewer, double now);

  /// True if the window should be drawn, apart from frame_comes_first().
  bool wants_to_draw(const Viewer& viewer, const Surroundings& around) const;

  /// True if the window should wait for a frame that is being rendered or for progress.
  bool frame_comes_first(const Viewer& viewer, const Surroundings& around) const;

  /// True if the loop may sleep until something happens. `numbers_wanted`: numbers_are_wanted().
  bool rests(const Viewer& viewer, const Surroundings& around, bool numbers_wanted) const;

  /// The time for which the loop waits for events, seconds.
  double sleep_seconds(const Viewer& viewer, const Surroundings& around, bool numbers_wanted) const;

  /// Called before the window is drawn; true if that disturbs a measurement, which is then void.
  bool begin_drawing(const Viewer& viewer);

  /// Called after the window was drawn. Returns the new pictures per second that the user sees,
  /// smoothed; 0 while the picture rests.
  double end_drawing(const Viewer& viewer, double now);

 private:
  bool draw_once_ = true;
  double draw_until_ = 0, last_draw_ = 0, last_picture_ = 0, fps_ = 0;
  std::size_t toasts_ = 0;  // in the window
  bool told_ = false;       // the window shows a change of the mode
  bool lost_ = false;       // the window shows the way to the subject
  bool hinted_ = false;     // the drawn window has hints
  int frames_ = -1;         // Viewer::frames in the window
  bool measuring_ = false;  // as the window shows it
};

}  // namespace qs
