// SPDX-License-Identifier: MIT
//
// The rate of a line, in bits per second, estimated from the messages that the page confirms. Pages
// seldom fill the line, so the bytes of a second do not show its rate. A message occupies the line
// from the time at which its first byte can arrive, half of an empty round trip before the
// confirmation at the earliest, or from the end of the message before it. A busy page makes a line
// seem slower, most of all by small messages. So the bounds of the rate come from large messages
// and from sequences of messages. They are learned again after a number of bytes, so that small
// messages alone also replace old bounds. A function of times alone.
#pragma once

#include <cstddef>
#include <deque>

namespace qs {

/// The rate of a line in bits per second, at most 1e9; 0: not known yet.
struct LineSpeed {
  double estimate = 0;
  double at_least = 0, at_most = 0;  ///< as the last messages have shown
};

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

}  // namespace qs
