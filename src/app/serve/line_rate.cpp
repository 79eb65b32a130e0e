// SPDX-License-Identifier: MIT
#include "app/serve/line_rate.h"

#include <algorithm>
#include <vector>

namespace qs {
namespace {

constexpr std::size_t kTrips = 8, kGroups = 7;
constexpr int kGroup = 4;                ///< messages
constexpr std::size_t kSmallest = 2048;  ///< bytes; smaller messages say little
constexpr double kMostRate = 1e9;

double rate_of(double bytes, double seconds) {
  return std::min(kMostRate, 8 * bytes / std::max(seconds, 1e-9));
}

}  // namespace

void LineRate::round_trip(double seconds, bool alone) {
  if (!trips_.empty() && !alone && seconds >= least()) return;
  trips_.push_back(std::max(seconds, 1e-6));
  if (trips_.size() > kTrips) trips_.pop_front();
}

double LineRate::least() const {
  return trips_.empty() ? 0 : *std::min_element(trips_.begin(), trips_.end());
}

void LineRate::confirmed(double sent, double confirmed, std::size_t bytes) {
  const double began = std::max(sent + least(), last_confirmed_);
  last_confirmed_ = std::max(last_confirmed_, confirmed);
  if (trips_.empty() || bytes < kSmallest) return;
  if (groups_.empty() || groups_.back().messages == kGroup) groups_.emplace_back();
  if (groups_.size() > kGroups) groups_.pop_front();
  Group& group = groups_.back();
  group.bytes += static_cast<double>(bytes);
  group.seconds += std::max(0.0, confirmed - began);
  ++group.messages;
}

double LineRate::bits_per_second() const {
  if (groups_.empty()) return 0;
  std::vector<double> rates;
  for (const Group& group : groups_) rates.push_back(rate_of(group.bytes, group.seconds));
  const auto middle = rates.begin() + static_cast<std::ptrdiff_t>(rates.size() / 2);
  std::nth_element(rates.begin(), middle, rates.end());
  return *middle;
}

}  // namespace qs
