// SPDX-License-Identifier: MIT
//
// The rate of a visitor's line, and the messages that may be in transit over it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

namespace qs {

/// The rate of a line in bits per second, at most 1e9; 0: not known yet.
struct LineSpeed {
  double estimate = 0;
  double at_least = 0, at_most = 0;  ///< as the last messages have shown
};

/// The rate of a line, in bits per second, estimated from the messages that the page confirms.
/// Pages seldom fill the line, so the bytes of a second do not show its rate. A message occupies
/// the line from the time at which its first byte can arrive, half of an empty round trip before
/// the confirmation at the earliest, or from the end of the message before it. A busy page makes a
/// line seem slower, most of all by small messages. So the bounds of the rate come from large
/// messages and from sequences of messages. They are learned again after a number of bytes, so that
/// small messages alone also replace old bounds. A function of times alone.
class LineRate {
 public:
  /// The round trip of a message without content, in seconds. `alone`: nothing else was in transit.
  void round_trip(double seconds, bool alone);

  /// A message of so many bytes was sent at `sent` and confirmed on its arrival at `confirmed`.
  /// Messages are confirmed in the order in which they were sent.
  void confirmed(double sent, double confirmed, std::size_t bytes);

  LineSpeed speed() const;

  /// Least seconds there and back; 0: not known yet.
  double least() const;

 private:
  // Messages that follow each other. A late confirmation makes one message seem slow and the next
  // fast, which their sum does not show.
  struct Group {
    double bytes = 0, seconds = 0;
    int messages = 0;
  };
  struct Message {
    double sent = 0, bytes = 0;
  };
  struct Bounds {
    double least = 0, most = 0;
  };
  void learn_bounds(double confirmed);
  double middle_of_groups() const;

  std::deque<double> trips_;  // the last round trips
  std::deque<Group> groups_;
  std::deque<Message> messages_;  // the last ones
  std::deque<Bounds> bounds_;     // that the last messages have shown
  double since_bounds_ = 0;       // bytes confirmed since the last bounds
  double last_confirmed_ = 0;
};

/// The messages with pictures that may be in transit to a visitor. A picture cannot be taken back
/// after it was sent, so a new one is made only when there is room. The page confirms every message
/// after it has shown it, so pictures that wait inside a tunnel count too. Times are seconds of one
/// clock.
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
