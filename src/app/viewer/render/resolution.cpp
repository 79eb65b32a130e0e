// SPDX-License-Identifier: MIT
#include "app/viewer/render/resolution.h"

#include <algorithm>

namespace qs {
namespace {

constexpr int kUsualDivisor = 3;  ///< a frame is reduced more only below 20 pictures a second
constexpr double kQuickShare = 0.8;
constexpr int kSlowFrames = 3, kQuickFrames = 6;  ///< in a row, before the divisor changes
constexpr double kMuchTooSlow = 1.5;              ///< times the limit: one frame is enough

double squared(double x) { return x * x; }

/// Bounds of a frame's time from the time of a frame with another divisor.
double least_ms(double ms, int from, int to) {
  return ms * squared(std::min(1.0, static_cast<double>(from) / to));
}
double most_ms(double ms, int from, int to) {
  return ms * squared(std::max(1.0, static_cast<double>(from) / to));
}

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

double longest_moving_ms(int divisor) { return divisor < kUsualDivisor ? 28 : 50; }

void Resolution::learn(int divisor, double ms) {
  const auto is_slow = [&](int n, double times) {
    return n < kMostDivisor && least_ms(ms, divisor, n) > times * longest_moving_ms(n);
  };
  const auto is_quick = [&](int n) {
    return n > 1 && most_ms(ms, divisor, n - 1) <= kQuickShare * longest_moving_ms(n - 1);
  };
  slow_ = is_slow(divisor_, 1) ? slow_ + 1 : 0;
  quick_ = is_quick(divisor_) ? quick_ + 1 : 0;
  if (slow_ >= kSlowFrames || is_slow(divisor_, kMuchTooSlow)) {
    while (is_slow(divisor_, 1)) ++divisor_;
    slow_ = 0;
  } else if (quick_ >= kQuickFrames) {
    while (is_quick(divisor_)) --divisor_;
    quick_ = 0;
  }
}

int refined(int divisor) { return divisor > kUsualDivisor ? kUsualDivisor : std::max(1, divisor - 1); }

}  // namespace qs
