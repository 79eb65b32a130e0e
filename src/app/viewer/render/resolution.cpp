// SPDX-License-Identifier: MIT
#include "app/viewer/render/resolution.h"

#include <algorithm>

namespace qs {
namespace {

/// The longest time of a frame that is reduced by `divisor` and not more.
double limit_ms(int divisor) {
  return divisor < kUsualDivisor ? kMovingFrameMs : kSlowestFrameMs;
}

/// The time for another divisor if only pixels cost time: the least for a larger one, the most for
/// a smaller one.
double scaled_ms(double ms, int from, int to) { return ms * from * from / (to * to); }

}  // namespace

Camera reduced(const Camera& camera, int divisor) {
  Camera result = camera;
  result.width = std::max(1, camera.width / divisor);
  result.height = std::max(1, camera.height / divisor);
  const glm::dvec2 scale = glm::dvec2(result.width, result.height) /
                           glm::dvec2(camera.width, camera.height);
  result.focal_px = camera.focal_px * scale;
  result.center_px = (camera.center_px + 0.5) * scale - 0.5;
  return result;
}

RenderSettings reduced(RenderSettings settings, int divisor) {
  settings.dilation /= divisor * divisor;
  return settings;
}

void Resolution::learn(int divisor, double ms) {
  int chosen = divisor;
  while (chosen < kMostDivisor && scaled_ms(ms, divisor, chosen) > limit_ms(chosen)) ++chosen;
  while (chosen > 1 &&
         scaled_ms(ms, divisor, chosen - 1) <= kFinerShare * limit_ms(chosen - 1))
    --chosen;
  divisor_ = chosen;
}

int refined(int divisor) { return divisor > kUsualDivisor ? kUsualDivisor : std::max(1, divisor - 1); }

}  // namespace qs
