// SPDX-License-Identifier: MIT
//
// The order in which modes take turns. A frame finds the caches and the clock as the frame before
// it left them. So the order changes from round to round: over the rounds every member follows
// every other member about equally often, and never itself. The order is the same in every run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace qs {

class TurnOrder {
 public:
  /// Begins with round `first_round`, so that measurements of few rounds have different orders.
  explicit TurnOrder(std::uint64_t first_round = 0) : first_round_(first_round) {}

  /// The numbers 0 to count - 1 in the order of the next round. Round 0 is in ascending order.
  /// Another `count` than before begins again.
  std::vector<std::size_t> next(std::size_t count);

 private:
  std::vector<std::size_t> next_round();

  std::uint64_t first_round_;
  std::vector<std::vector<int>> follows_;  // [before][after], rounds so far
  std::vector<std::vector<int>> places_;   // [member][place], rounds so far
  std::size_t last_ = 0;                   // last member of the round before; the count in round 0
};

}  // namespace qs
