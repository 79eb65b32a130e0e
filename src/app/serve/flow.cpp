// SPDX-License-Identifier: MIT
#include "app/serve/flow.h"

#include <algorithm>
#include <cmath>

namespace qs {
namespace {

constexpr double kWantedRate = 60;  ///< messages per second
constexpr int kMostWindow = 4;
constexpr double kQueueSeconds = 0.06;  ///< above the least time: messages wait in transit

}  // namespace

void PictureFlow::sent(double now) { in_transit_.push_back(now); }

bool PictureFlow::received(std::uint32_t count, double now) {
  const std::uint32_t more = count - received_;  // the count may wrap
  if (more > in_transit_.size()) return false;
  received_ = count;
  for (std::uint32_t i = 0; i < more; ++i) {
    const double seconds = std::max(now - in_transit_.front(), 1e-4);
    in_transit_.pop_front();
    least_ = least_ > 0 ? std::min(least_, seconds) : seconds;
    const int wanted =
        std::clamp(static_cast<int>(std::ceil(kWantedRate * least_)), 1, kMostWindow);
    window_ = seconds > least_ + kQueueSeconds ? std::max(1, window_ - 1) : wanted;
  }
  return true;
}

}  // namespace qs
