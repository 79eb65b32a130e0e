// SPDX-License-Identifier: MIT
#include "app/measure/turn_order.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace qs {

std::vector<std::size_t> TurnOrder::next(std::size_t count) {
  if (places_.size() != count) {
    follows_.assign(count + 1, std::vector<int>(count));  // the last row is the start's
    places_.assign(count, std::vector<int>(count));
    last_ = count;
    for (std::uint64_t round = 0; round < first_round_; ++round) next_round();
  }
  return next_round();
}

// Always chooses the member that followed its predecessor least often, and among several such
// members the member with the fewest rounds at this place.
std::vector<std::size_t> TurnOrder::next_round() {
  std::vector<std::size_t> left(places_.size()), order;
  std::iota(left.begin(), left.end(), std::size_t{0});
  while (!left.empty()) {
    const std::size_t place = order.size();
    const auto rank = [&](std::size_t member) {
      return std::tuple(member == last_, follows_[last_][member], places_[member][place], member);
    };
    const auto chosen = std::ranges::min_element(left, {}, rank);
    ++follows_[last_][*chosen];
    ++places_[*chosen][place];
    last_ = *chosen;
    order.push_back(*chosen);
    left.erase(chosen);
  }
  return order;
}

}  // namespace qs
