// SPDX-License-Identifier: MIT
//
// Keeps timed frames of a job apart from the drawing of the window, which takes time from the same
// CPU or GPU. The window is drawn whenever it has to be; the frames that a drawing met are void,
// and the job measures again once the window rests.
#pragma once

#include <chrono>
#include <thread>

#include "app/viewer/render/render_context.h"
#include "base/progress.h"

namespace qs {

/// Waits until the window rests and returns RenderContext::drawings of that moment. Throws
/// Cancelled if the job is stopped.
inline int wait_for_rest(const RenderContext& context) {
  constexpr std::chrono::milliseconds kPause{2};
  for (;;) {
    if (context.stop.stop_requested()) throw Cancelled{};
    if (context.give_way) context.give_way();
    const int drawings = context.drawings;  // before the other: note_drawing() sets it last
    if (context.window_rests) return drawings;
    std::this_thread::sleep_for(kPause);
  }
}

/// Calls measure(progress) while the window rests, and again if the window was drawn meanwhile.
/// Returns the result without a drawing. Throws Cancelled if the job is stopped.
template <class Measure>
auto undisturbed(RenderContext& context, const Measure& measure) {
  for (;;) {
    const int drawings = wait_for_rest(context);
    std::stop_source stop;
    const std::stop_callback stopped(context.stop, [&] { stop.request_stop(); });
    const Progress progress{[&](float) {
                              if (context.drawings != drawings) stop.request_stop();
                            },
                            stop.get_token()};
    try {
      auto result = measure(progress);
      if (context.drawings == drawings) return result;
    } catch (const Cancelled&) {
      if (context.stop.stop_requested()) throw;
    }
  }
}

}  // namespace qs
