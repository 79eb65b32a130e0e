// SPDX-License-Identifier: MIT
#include "app/viewer/pacing.h"

#include <algorithm>
#include <utility>

#include "app/viewer/state/lost.h"
#include "app/viewer/state/training_actions.h"

namespace qs {
namespace {

constexpr double kBusySeconds = 0.01;      ///< sleep while other threads work
constexpr double kRestSeconds = 0.5;       ///< longest sleep
constexpr double kUiSeconds = 0.35;        ///< panels are drawn this long after the last event
constexpr double kPatienceSeconds = 0.03;  ///< longest wait for a frame
constexpr double kLoadingSeconds = 0.06;   ///< between drawings while a scene is read
/// time between drawings while a model is trained and nothing moves
constexpr double kTrainingSeconds = 0.2;
constexpr double kPauseSeconds = 0.25;  ///< a longer gap between drawings is not a frame rate

}  // namespace

void Pacing::note_change(const Viewer& viewer, double now) {
  draw_once_ = true;
  if (!viewer.measuring && !viewer.zoom.running) draw_until_ = now + kUiSeconds;
}

bool Pacing::wants_to_draw(const Viewer& viewer, const Surroundings& around) const {
  // A measurement also ends without an action, if it is cancelled or its report comes first.
  const bool ended = measuring_ && !viewer.measuring;
  const bool told = viewer.mode_switch.has_value() != told_ || is_lost(viewer) != lost_ ||
                    viewer.hints.any() != hinted_;
  // A recorded zoom shows its own frames.
  const bool continuous = (!viewer.on_demand || viewer.playback.running) && !viewer.zoom.running;
  return draw_once_ || ended || told || viewer.toasts.size() != toasts_ ||
         around.now < draw_until_ || around.now - around.last_event < kUiSeconds || continuous ||
         (viewer.loading && !viewer.measuring) || viewer.moving();
}

bool Pacing::frame_comes_first(const Viewer& viewer, const Surroundings& around) const {
  const bool shows_newest = frames_ == viewer.frames;
  if (viewer.loading) return shows_newest && around.now - last_draw_ < kLoadingSeconds;
  // Drawing panels takes time from the trainer too.
  if (is_training(viewer) && !viewer.moving() && around.now - around.last_event > kUiSeconds)
    return shows_newest && around.now - last_draw_ < kTrainingSeconds;
  const bool waits = !viewer.on_demand || viewer.moving();
  return waits && shows_newest && around.render_busy && around.now - last_draw_ < kPatienceSeconds;
}

bool Pacing::rests(const Viewer& viewer, const Surroundings& around, bool numbers_wanted) const {
  return !wants_to_draw(viewer, around) && !around.has_pending && viewer.still() && !numbers_wanted;
}

double Pacing::sleep_seconds(const Viewer& viewer, const Surroundings& around,
                             bool numbers_wanted) const {
  if (rests(viewer, around, numbers_wanted)) return kRestSeconds;
  if (frame_comes_first(viewer, around)) return kPatienceSeconds;
  return wants_to_draw(viewer, around) ? 0 : kBusySeconds;
}

bool Pacing::begin_drawing(const Viewer& viewer) {
  const bool disturbs = viewer.measuring && !draw_once_ && viewer.toasts.size() == toasts_;
  draw_once_ = false;
  measuring_ = viewer.measuring;
  toasts_ = viewer.toasts.size();
  told_ = viewer.mode_switch.has_value();
  lost_ = is_lost(viewer);
  hinted_ = viewer.hints.any();
  return disturbs;
}

double Pacing::end_drawing(const Viewer& viewer, double now) {
  const bool paused = now - std::exchange(last_draw_, now) >= kPauseSeconds;
  const bool new_picture = std::exchange(frames_, viewer.frames) != viewer.frames;
  if (paused) fps_ = 0;
  if (paused || new_picture) {
    const double seconds = now - std::exchange(last_picture_, now);
    const double fps = paused || seconds <= 0 ? 0 : 1 / seconds;
    fps_ = fps == 0 || fps_ == 0 ? fps : 0.9 * fps_ + 0.1 * fps;
  }
  if (viewer.on_demand && !viewer.moving()) return 0;
  // The picture that is being drawn takes at least this long.
  const double seconds = now - last_picture_;
  return seconds > 0 ? std::min(fps_, 1 / seconds) : fps_;
}

}  // namespace qs
