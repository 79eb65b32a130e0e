// SPDX-License-Identifier: MIT
#include "app/serve/flow.h"

#include <algorithm>
#include <cmath>

namespace qs {
namespace {

constexpr double kWantedRate = 60;  ///< messages per second
constexpr int kMostWindow = 4;
constexpr double kQueueSeconds = 0.06;    ///< above the least time: messages wait in transit
constexpr double kPartSeconds = 0.03;     ///< that parts may wait in transit, by the line's rate
constexpr double kLatePart = 0.05;        ///< seconds above an empty round trip
constexpr double kLeastRoom = 32768;      ///< bytes of parts
constexpr std::size_t kLastPictures = 4;  ///< pictures whose slowest one is expected again

}  // namespace

void PictureFlow::sent(double now, std::size_t bytes, bool is_part) {
  if (is_part && parts_ == 0)
    part_room_ = std::max(kLeastRoom, rate_.speed().estimate / 8 * (rate_.least() + kPartSeconds));
  in_transit_.push_back({now, bytes, is_part});
  bytes_ += bytes;
  ++(is_part ? parts_ : pictures_);
}

bool PictureFlow::received(std::uint32_t count, double held, double now) {
  const std::uint32_t more = count - received_;  // the count may wrap
  if (more > in_transit_.size()) return false;
  received_ = count;
  for (std::uint32_t i = 0; i < more; ++i) {
    const InTransit first = in_transit_.front();
    in_transit_.pop_front();
    bytes_ -= first.bytes;
    --(first.is_part ? parts_ : pictures_);
    const double arrived = std::max(first.sent, now - held);
    rate_.confirmed(first.sent, arrived, first.bytes);
    if (first.is_part) {
      learn_part(arrived - first.sent, first.bytes);
      continue;
    }
    const double seconds = std::max(now - first.sent, 1e-4);
    trips_.push_back(seconds);
    if (trips_.size() > kLastPictures) trips_.pop_front();
    least_ = least_ > 0 ? std::min(least_, seconds) : seconds;
    const int wanted =
        std::clamp(static_cast<int>(std::ceil(kWantedRate * least_)), 1, kMostWindow);
    window_ = seconds > least_ + kQueueSeconds ? std::max(1, window_ - 1) : wanted;
  }
  return true;
}

std::optional<double> PictureFlow::next_room(int coming) const {
  if (pictures_ == 0 || pictures_ + coming != window_ || trips_.empty()) return {};
  const auto oldest = std::find_if(in_transit_.begin(), in_transit_.end(),
                                   [](const InTransit& one) { return !one.is_part; });
  return oldest->sent + *std::max_element(trips_.begin(), trips_.end());
}

bool PictureFlow::has_room_for_part(std::size_t bytes) const {
  return parts_ == 0 || static_cast<double>(bytes_ + bytes) <= part_room_;
}

void PictureFlow::learn_part(double seconds, std::size_t bytes) {
  const auto change = static_cast<double>(bytes);
  if (seconds < rate_.least() + kLatePart) {
    part_room_ += change;
  } else {
    part_room_ = std::max(kLeastRoom, part_room_ - change / 2);
  }
}

}  // namespace qs
