// SPDX-License-Identifier: MIT
//
// The messages with pictures that may be in transit to a visitor. A picture cannot be taken back
// after it was sent, so a new one is made only when there is room. The page confirms every message
// after it has shown it, so pictures that wait inside a tunnel count too. Times are seconds of one
// clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "app/serve/line_rate.h"

namespace qs {

class PictureFlow {
 public:
  /// `is_part`: of a picture at rest, which has room of its own.
  void sent(double now, std::size_t bytes, bool is_part);

  /// The page has received `count` messages so far, the last one `held` seconds before it confirmed
  /// it. False if it cannot have received so many.
  bool received(std::uint32_t count, double held, double now);

  /// The round trip of an empty message. `alone`: see LineRate::round_trip().
  void round_trip(double seconds, bool alone) { rate_.round_trip(seconds, alone); }

  /// One more moving picture may be in transit beside `coming` pictures that are being made.
  bool has_room(int coming = 0) const { return pictures_ + coming < window_; }

  /// The expected time at which the next confirmation will make room for a moving picture beside
  /// `coming` pictures. A picture that is ordered before can be ready then. None if no picture is
  /// in transit, or if one confirmation is not enough.
  std::optional<double> next_room(int coming) const;

  /// A part of a picture at rest may be sent beside the bytes in transit. There is room for as many
  /// as the line carries in 30 ms more than a round trip; for more while parts arrive within 50 ms
  /// more than it, because the rate may be underestimated; and for less when they do not. So the
  /// first moving picture afterwards waits little.
  bool has_room_for_part(std::size_t bytes) const;

  int window() const { return window_; }
  std::uint32_t received() const { return received_; }
  /// Nothing is in transit.
  bool is_empty() const { return in_transit_.empty(); }
  LineSpeed speed() const { return rate_.speed(); }

 private:
  struct InTransit {
    double sent = 0;
    std::size_t bytes = 0;
    bool is_part = false;
  };
  std::deque<InTransit> in_transit_;
  void learn_part(double seconds, std::size_t bytes);

  std::size_t bytes_ = 0;  // in transit
  double part_room_ = 0;   // bytes, with parts in transit
  int pictures_ = 0;       // in transit, without parts
  int parts_ = 0;          // in transit
  std::uint32_t received_ = 0;
  double least_ = 0;          // seconds from sending to confirmation; 0: not known
  std::deque<double> trips_;  // such seconds of the last pictures
  int window_ = 2;
  LineRate rate_;
};

}  // namespace qs
