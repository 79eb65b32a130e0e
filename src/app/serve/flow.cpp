// SPDX-License-Identifier: MIT
#include "app/serve/flow.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "base/rank.h"

namespace qs {
namespace {

constexpr std::size_t kTrips = 8, kGroups = 7;
constexpr int kGroup = 4;                ///< messages
constexpr std::size_t kSmallest = 2048;  ///< bytes; smaller messages say little
constexpr double kMostRate = 1e9;
constexpr std::size_t kRemembered = 32;  ///< messages
constexpr double kBoundsBytes = 12000;   ///< of one message or of several, that show bounds
constexpr double kBusyPage = 0.005;      ///< seconds that a page may confirm a message late
constexpr std::size_t kBounds = 16;      ///< that are remembered
constexpr std::size_t kAgreeing = 2;     ///< of them

double rate_of(double bytes, double seconds) {
  return std::min(kMostRate, 8 * bytes / std::max(seconds, 1e-9));
}

constexpr double kWantedRate = 60;  ///< messages per second
constexpr int kMostWindow = 4;
constexpr double kQueueSeconds = 0.06;    ///< above the least time: messages wait in transit
constexpr double kPartSeconds = 0.03;     ///< that parts may wait in transit, by the line's rate
constexpr double kLatePart = 0.05;        ///< seconds above an empty round trip
constexpr double kLeastRoom = 32768;      ///< bytes of parts
constexpr std::size_t kLastPictures = 4;  ///< pictures whose slowest one is expected again

}  // namespace

// ---- the rate of the line -----------------------------------------------------------------------
void LineRate::round_trip(double seconds, bool alone) {
  if (!trips_.empty() && !alone && seconds >= least()) return;
  trips_.push_back(std::max(seconds, 1e-6));
  if (trips_.size() > kTrips) trips_.pop_front();
}

double LineRate::least() const { return trips_.empty() ? 0 : std::ranges::min(trips_); }

void LineRate::confirmed(double sent, double confirmed, std::size_t bytes) {
  const double began = std::max(sent + least(), last_confirmed_);
  last_confirmed_ = std::max(last_confirmed_, confirmed);
  messages_.push_back({sent, static_cast<double>(bytes)});
  if (messages_.size() > kRemembered) messages_.pop_front();
  if (trips_.empty() || bytes < kSmallest) return;
  since_bounds_ += static_cast<double>(bytes);
  if (since_bounds_ >= kBoundsBytes) learn_bounds(confirmed);
  if (groups_.empty() || groups_.back().messages == kGroup) groups_.emplace_back();
  if (groups_.size() > kGroups) groups_.pop_front();
  Group& group = groups_.back();
  group.bytes += static_cast<double>(bytes);
  group.seconds += std::max(0.0, confirmed - began);
  ++group.messages;
}

// Messages that were sent at or after a time have crossed the line between then and the last
// confirmation, and other delays only add to that time. So no sequence of messages shows more than
// the line's rate, and the fastest one shows most of it.
void LineRate::learn_bounds(double confirmed) {
  since_bounds_ = 0;
  double bytes = 0;
  Bounds bounds;
  for (auto message = messages_.rbegin(); message != messages_.rend(); ++message) {
    bytes += message->bytes;
    const double seconds = confirmed - message->sent - least();
    bounds.least = std::max(bounds.least, rate_of(bytes, seconds));
    bounds.most = std::max(bounds.most, rate_of(bytes, seconds - kBusyPage));
  }
  bounds_.push_back(bounds);
  if (bounds_.size() > kBounds) bounds_.pop_front();
}

LineSpeed LineRate::speed() const {
  LineSpeed speed;
  std::vector<double> least;
  for (const Bounds& bounds : bounds_) {
    least.push_back(bounds.least);
    speed.at_most = std::max(speed.at_most, bounds.most);
  }
  // The largest one may be wrong, because the line's round trip has become shorter.
  std::ranges::sort(least, std::greater<>());
  if (!least.empty()) speed.at_least = least[std::min(kAgreeing, least.size()) - 1];
  speed.estimate = std::max(middle_of_groups(), speed.at_least);
  return speed;
}

double LineRate::middle_of_groups() const {
  if (groups_.empty()) return 0;
  std::vector<double> rates;
  for (const Group& group : groups_) rates.push_back(rate_of(group.bytes, group.seconds));
  return upper_median(std::move(rates));
}

// ---- messages in transit ------------------------------------------------------------------------
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
  const auto oldest = std::ranges::find(in_transit_, false, &InTransit::is_part);
  return oldest->sent + std::ranges::max(trips_);
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
