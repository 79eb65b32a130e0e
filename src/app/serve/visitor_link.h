// SPDX-License-Identifier: MIT
//
// The messages between the server and the page of one visitor, without sockets and threads. The
// owner reports events and calls advance(), which says what to write and when to call it again.
// The link owns the flow of pictures, the pictures and files that wait to be sent, and the state
// that the page has. Times are seconds of one clock.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/serve/connections.h"
#include "app/serve/flow.h"
#include "app/serve/state_json.h"
#include "app/serve/visitor.h"

namespace qs {

/// The codes with which the server closes a WebSocket; page.js has words for some of them.
enum class CloseCode : std::uint16_t {
  binary = 1003,
  no_json = 1007,
  too_many = 1008,
  failed = 1011,
  try_later = 1013,
  wrong_token = 4401,
};

class VisitorLink {
 public:
  /// Shared by all links, which it outlives.
  struct Room {
    const ServeLimits& limits;
    const std::string& token;
    const std::vector<const OpenedScene*>& scenes;
    std::array<SentPictures, 4>& sent;  ///< index = PictureCodec
  };

  VisitorLink(const Room& room, double now);

  // ---- events -----------------------------------------------------------------------------------
  enum class Taken { message, hello, wrong_token, nothing };
  /// A message of the page. `hello`: the page has shown the token, so there is a visitor now.
  /// `nothing`: the link is being closed, and reads no further message.
  Taken take(std::string_view text, bool is_binary, double now);
  /// The last message has left.
  void written(double now);
  void ping_written() { writes_ping_ = false; }
  void pong(double now);
  /// The page says goodbye: the end of the connection may take no longer than a message.
  void page_closes(double now) { leaves_by_ = now + write_seconds(); }
  void picture_drawn(double now);
  void picture_ready(Picture picture, double now);
  /// A message that is being written is finished first. The first code counts.
  void close(CloseCode code, const char* reason);

  // ---- what is due ------------------------------------------------------------------------------
  struct Close {
    CloseCode code = CloseCode::failed;
    const char* reason = "";
  };
  struct Message {
    std::string bytes;
    bool is_text = false;
  };
  struct Step {
    bool is_dead = false;            ///< a message has not left in time: end the connection
    std::optional<Close> close;      ///< begin the end of the connection
    bool pings = false;              ///< send a ping before the message
    std::optional<Message> message;  ///< write it and call written()
    bool cancels_lossless = false;   ///< the exact picture in work is of no use now
    std::optional<PictureOrder> order;
    double wake_at = 0;  ///< call advance() then, or after an event; infinite: only after an event
  };
  /// `pass_on` takes what the visitor's actions ask for, after the visitor has moved and before a
  /// picture is ordered.
  Step advance(double now, const std::function<void(Visitor&)>& pass_on);

  bool is_closing() const { return closing_.has_value(); }
  /// Null before the token, and when the link is being closed.
  Visitor* visitor() { return visitor_ && !closing_ ? &*visitor_ : nullptr; }
  /// Also when the link is being closed.
  const Visitor* last_visitor() const { return visitor_ ? &*visitor_ : nullptr; }
  /// Step::wake_at as it is now.
  double next_wake() const;

 private:
  double write_seconds() const;
  bool is_within_rate(double now);
  void tick_if_due(double now);
  void drop_lossless();
  std::optional<PictureOrder> next_order(double now);
  std::optional<Message> next_state(double now);
  std::optional<Message> next_part(Step& step, double now);
  std::optional<Message> next_file_part(double now);
  bool pings_now(double now);

  const Room room_;
  const double began_;
  std::optional<Visitor> visitor_;  // set by the right token
  std::optional<Close> closing_;
  PictureFlow flow_;

  double second_began_ = 0;
  int messages_ = 0;  // of the page in this second

  bool writing_ = false;                // a message or the end of the connection
  std::optional<double> leaves_by_;     // else the connection is dead
  SentPictures* writes_for_ = nullptr;  // counts the time of the message; null: not a picture
  double writes_since_ = 0;

  bool pings_ = false;        // no answer has come
  bool writes_ping_ = false;  // a page may answer before it has left, and one ping leaves at a time
  bool pinged_alone_ = false;
  double pinged_ = 0, next_ping_ = 0;

  StateSections sections_;     // as the page has them
  std::uint32_t version_ = 0;  // of the state
  double next_state_ = 0;
  bool checks_state_ = false;  // at next_state_, because the state may have changed since

  std::optional<double> turn_at_;   // of a visitor who moves
  std::optional<double> order_at_;  // when a picture is to be ordered; unset: after an event
  double next_order_ = 0;
  double rendering_seconds_ = 0, encoding_seconds_ = 0;  // of the last moving picture
  double making_seconds_ = 0;  // of the last moving picture, from the order to its bytes
  int in_work_ = 0;            // pictures that were ordered and are not complete
  bool renders_ = false;       // one of these has not been drawn

  std::deque<Picture> outgoing_;
  std::size_t sent_bytes_ = 0;  // bytes of outgoing_.front() that were sent
  std::uint32_t picture_ = 0;   // number of the last picture that was sent
  std::deque<SentFile> files_;
  std::size_t sent_of_file_ = 0;  // bytes of files_.front() that were sent
  std::uint32_t file_ = 0;        // number of files_.front()
};

}  // namespace qs
