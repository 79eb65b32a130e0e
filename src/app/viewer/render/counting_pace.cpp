// SPDX-License-Identifier: MIT
#include "app/viewer/render/counting_pace.h"

#include <algorithm>
#include <cmath>

#include "app/viewer/state/samples.h"

namespace qs {

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
