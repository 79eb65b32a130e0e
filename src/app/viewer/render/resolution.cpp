// SPDX-License-Identifier: MIT
#include "app/viewer/render/resolution.h"

#include <algorithm>

namespace qs {
namespace {

constexpr int kUsualDivisor = 3;
constexpr double kWorthwhile = 0.25;  ///< saved by reducing a frame more than usual
constexpr double kQuickShare = 0.8;
constexpr int kSlowFrames = 3, kQuickFrames = 6;  ///< in a row, before the divisor changes
constexpr double kMuchTooSlow = 1.5;              ///< times the limit: one frame is enough

/// Pixels of a frame reduced by `to` for one pixel of a frame reduced by `from`.
double pixels(int from, int to) { return static_cast<double>(from * from) / (to * to); }

}  // namespace

RenderSettings reduced(RenderSettings settings, int divisor) {
  settings.dilation /= divisor * divisor;
  return settings;
}

double longest_moving_ms(int divisor) { return divisor < kUsualDivisor ? 28 : 50; }

FrameCost cost_of(const RenderStats& stats) {
  const auto ms = [&](Stage stage) {
    return static_cast<double>(stats.stage_ms[static_cast<int>(stage)]);
  };
  return {static_cast<double>(stats.frame_ms), ms(Stage::bin) + ms(Stage::blend)};
}

void Resolution::learn(int divisor, const FrameCost& cost) {
  // Bounds of the time of a frame with the divisor n.
  const auto least = [&](int n) {
    return cost.ms - cost.pixels_ms * (1 - std::min(1.0, pixels(divisor, n)));
  };
  const auto most = [&](int n) { return cost.ms * std::max(1.0, pixels(divisor, n)); };
  const auto is_slow = [&](int n, double times) {
    if (n == kMostDivisor || least(n) <= times * longest_moving_ms(n)) return false;
    return n < kUsualDivisor || least(n + 1) <= (1 - kWorthwhile) * least(n);
  };
  const auto is_quick = [&](int n) {
    return n > 1 && most(n - 1) <= kQuickShare * longest_moving_ms(n - 1);
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

int refined(int divisor) {
  return divisor > kUsualDivisor ? kUsualDivisor : std::max(1, divisor - 1);
}

}  // namespace qs
