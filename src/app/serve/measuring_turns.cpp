// SPDX-License-Identifier: MIT
#include "app/serve/measuring_turns.h"

#include <algorithm>

namespace qs {

void MeasuringTurns::want(const Turn& turn) {
  if (!spent_ms_.contains(turn.visitor)) {
    // Time before the visitor came is no claim.
    const auto least =
        std::min_element(spent_ms_.begin(), spent_ms_.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    spent_ms_[turn.visitor] = least == spent_ms_.end() ? 0 : least->second;
  }
  wanted_[turn.visitor] = turn;
}

void MeasuringTurns::drop(int visitor) { wanted_.erase(visitor); }

void MeasuringTurns::forget(int visitor) {
  wanted_.erase(visitor);
  spent_ms_.erase(visitor);
}

std::optional<MeasuringTurns::Turn> MeasuringTurns::next() const {
  const auto found = std::min_element(
      wanted_.begin(), wanted_.end(),
      [&](const auto& a, const auto& b) { return spent_ms_.at(a.first) < spent_ms_.at(b.first); });
  return found == wanted_.end() ? std::nullopt : std::optional(found->second);
}

void MeasuringTurns::measured(int visitor, int version, double ms, bool answered) {
  const auto spent = spent_ms_.find(visitor);
  if (spent != spent_ms_.end()) spent->second += ms;
  const auto found = wanted_.find(visitor);
  if (answered && found != wanted_.end() && found->second.request.version == version)
    wanted_.erase(found);
}

}  // namespace qs
