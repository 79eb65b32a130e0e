// SPDX-License-Identifier: MIT
#include "app/serve/flow.h"

#include <algorithm>
#include <cmath>

namespace qs {
namespace {

constexpr double kWantedRate = 60;  ///< messages per second
constexpr int kMostWindow = 4;
constexpr double kQueueSeconds = 0.06;  ///< above the least time: messages wait on their way

}  // namespace

void PictureFlow::sent(double now) { on_the_way_.push_back(now); }

bool PictureFlow::received(std::uint32_t count, double now) {
  const std::uint32_t more = count - received_;  // the count may wrap
  if (more > on_the_way_.size()) return false;
  received_ = count;
  for (std::uint32_t i = 0; i < more; ++i) {
    const double seconds = std::max(now - on_the_way_.front(), 1e-4);
    on_the_way_.pop_front();
    least_ = least_ > 0 ? std::min(least_, seconds) : seconds;
    const int wanted =
        std::clamp(static_cast<int>(std::ceil(kWantedRate * least_)), 1, kMostWindow);
    window_ = seconds > least_ + kQueueSeconds ? std::max(1, window_ - 1) : wanted;
  }
  return true;
}

}  // namespace qs
