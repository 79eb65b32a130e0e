// SPDX-License-Identifier: MIT
//
// The WebSocket of a visitor: it reports events to a VisitorLink, and writes what the link says.
#pragma once

#include <memory>

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>

#include "app/serve/client_stream.h"
#include "app/serve/hub.h"
#include "app/serve/visitor_link.h"

namespace qs {

class Live : public std::enable_shared_from_this<Live> {
 public:
  using Head = boost::beast::http::request<boost::beast::http::empty_body>;

  Live(Hub& hub, ClientStream stream, Place place);
  ~Live();

  void accept(const Head& request);

  /// Reports an event to the link by `tell(link, now)`, and then does the work that is due.
  template <class Tell>
  void handle(Tell&& tell) {
    if (stopped_) return;
    guarded(*this, [&] {
      tell(link_, seconds_now());
      proceed();
    });
  }
  /// The same for an event of a visitor, by `tell(visitor, now)`.
  template <class Tell>
  void handle_visitor(Tell&& tell) {
    handle([&](VisitorLink& link, double now) {
      if (Visitor* const visitor = link.visitor()) tell(*visitor, now);
    });
  }
  /// An exception ended a handler.
  void give_up();

 private:
  using ErrorCode = boost::system::error_code;

  void proceed();
  void read();
  void take();
  void greet();
  void pass_on(Visitor& visitor);
  void ping();
  void write(VisitorLink::Message message);
  void close(const VisitorLink::Close& close);
  void wake_at(double time);
  void stop();

  Hub& hub_;
  boost::beast::websocket::stream<ClientStream> socket_;
  Place place_;
  int number_;
  VisitorLink link_;
  boost::asio::steady_timer timer_;  // of VisitorLink::Step::wake_at
  boost::beast::flat_buffer buffer_;
  std::string text_;  // the message that is being written
  bool stopped_ = false;
};

}  // namespace qs
