// SPDX-License-Identifier: MIT
//
// The number of messages with pictures that may be in transit to a visitor. A picture cannot be
// taken back after it was sent, so a new one is made only when there is room. The page confirms
// every message after it has shown it, so pictures that wait inside a tunnel count too.
#pragma once

#include <cstdint>
#include <deque>

namespace qs {

class PictureFlow {
 public:
  /// Times are seconds of one clock.
  void sent(double now);

  /// The page has received `count` messages so far. False if it cannot have received so many.
  bool received(std::uint32_t count, double now);

  bool has_room() const { return static_cast<int>(in_transit_.size()) < window_; }
  int window() const { return window_; }
  std::uint32_t received() const { return received_; }
  /// Nothing is in transit.
  bool is_empty() const { return in_transit_.empty(); }

 private:
  std::deque<double> in_transit_;  // the times at which they were sent
  std::uint32_t received_ = 0;
  double least_ = 0;  // seconds from sending to confirmation; 0: not known
  int window_ = 2;
};

}  // namespace qs
