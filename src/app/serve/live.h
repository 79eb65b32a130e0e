// SPDX-License-Identifier: MIT
//
// The state that all connections of the web server share, on the thread of the network, and the
// WebSocket of a visitor: it reports events to a VisitorLink, and writes what the link says. Part
// of server.cpp, the only file that compiles the network library.
#pragma once

#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "app/serve/client_stream.h"
#include "app/serve/connections.h"
#include "app/serve/requests.h"
#include "app/serve/served_training.h"
#include "app/serve/server.h"
#include "app/serve/sharing.h"
#include "app/serve/visitor_link.h"
#include "app/viewer/render/upload_scene.h"

namespace qs {

namespace websocket = beast::websocket;

class Live;

struct Hub {
  ServeOptions options;
  HostNames names{"", ""};
  std::optional<TlsContext> tls;
  Connections connections{options.limits};
  std::map<int, std::weak_ptr<Live>> live;  ///< by number of the visitor
  std::vector<const OpenedScene*> scenes;
  Pictures* pictures = nullptr;
  ServedTraining* training = nullptr;
  Sharing sharing;
  std::array<SentPictures, 4> sent;
  /// The last member, so that its connections, which use the other members, end first.
  asio::io_context io;
};

using Place = std::unique_ptr<Connections::Place>;
using SteadyClock = std::chrono::steady_clock;

/// Runs the work of a handler. An exception ends its owner, and not the server.
template <class Owner, class Work>
void guarded(Owner& owner, Work&& work) {
  try {
    work();
  } catch (const std::exception&) {
    owner.give_up();
  }
}

class Live : public std::enable_shared_from_this<Live> {
 public:
  Live(Hub& hub, ClientStream stream, Place place)
      : hub_(hub),
        socket_(std::move(stream)),
        place_(std::move(place)),
        number_(hub.pictures->new_visitor()),
        link_({hub.options.limits, hub.options.token, hub.scenes, hub.sent}, seconds_now()),
        timer_(hub.io) {}
  ~Live() {
    hub_.live.erase(number_);
    if (hub_.pictures != nullptr) hub_.pictures->forget(number_);
  }

  void accept(const beast::http::request<beast::http::empty_body>& request) {
    const ServeLimits& limits = hub_.options.limits;
    beast::get_lowest_layer(socket_).expires_never();
    socket_.set_option(websocket::stream_base::timeout{limits.head_time, limits.pong_time, true});
    socket_.read_message_max(limits.message_bytes);
    socket_.control_callback([this](websocket::frame_type kind, beast::string_view payload) {
      if (kind == websocket::frame_type::pong && payload == kPing) link_.pong(seconds_now());
      if (kind != websocket::frame_type::close) return;
      link_.page_closes(seconds_now());
      wake_at(link_.next_wake());
    });
    socket_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (error) return;
      self->hub_.live[self->number_] = self->weak_from_this();
      self->go_on();
      self->read();
    });
  }

  /// Does the work that is due.
  void go_on() {
    guarded(*this, [&] { proceed(); });
  }
  /// Reports an event by `tell(link, now)` or `tell(visitor, now)`, and then does the work that is
  /// due.
  template <class Tell>
  void handle(Tell&& tell) {
    if (stopped_) return;
    guarded(*this, [&] {
      if constexpr (std::is_invocable_v<Tell, VisitorLink&, double>) {
        tell(link_, seconds_now());
      } else if (Visitor* const visitor = link_.visitor()) {
        tell(*visitor, seconds_now());
      }
      proceed();
    });
  }
  /// An exception ended a handler.
  void give_up() {
    try {
      link_.close(CloseCode::failed, "the server cannot go on with this visitor");
      proceed();
    } catch (const std::exception&) {
      stop();
    }
  }

 private:
  static constexpr const char* kPing = "q";  ///< Beast pings with an empty text
  static constexpr int kNobody = 0;          ///< no visitor has this number

  // Reads the next message.
  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->stop();
      guarded(*self, [&] { self->take(); });
    });
  }

  void take() {
    const std::string text = beast::buffers_to_string(buffer_.data());
    buffer_.consume(buffer_.size());
    const VisitorLink::Taken taken = link_.take(text, socket_.got_binary(), seconds_now());
    if (taken == VisitorLink::Taken::wrong_token)
      hub_.connections.note_wrong_token(place_->address(), SteadyClock::now());
    if (taken == VisitorLink::Taken::hello) greet();
    proceed();
    if (!link_.is_closing()) read();
  }

  void greet() {
    socket_.read_message_max(hub_.options.limits.message_bytes + 2 * kMostFile);  // with escapes
    if (!place_->move_to(ConnectionKind::visitor))
      return link_.close(CloseCode::try_later, "too many visitors");
    if (hub_.training != nullptr)
      link_.visitor()->apply({hub_.training->greeting()}, seconds_now());
  }

  // Does what the link says.
  void proceed() {
    if (stopped_) return;
    VisitorLink::Step step =
        link_.advance(seconds_now(), [this](Visitor& visitor) { pass_on(visitor); });
    if (step.is_dead) return stop();
    if (step.cancels_lossless) hub_.pictures->cancel_lossless(number_);
    if (step.order) hub_.pictures->order(number_, std::move(*step.order));
    if (step.pings) ping();
    if (step.message) write(std::move(*step.message));
    if (step.close) close(*step.close);
    wake_at(step.wake_at);
  }

  // Follows the other visitors or makes them follow, and passes on the requests of the visitor.
  void pass_on(Visitor& visitor) {
    if (hub_.sharing.meet(visitor, seconds_now())) {
      for (const auto& [number, live] : hub_.live) {
        if (number == number_) continue;
        asio::post(hub_.io, [live = live] {
          if (const std::shared_ptr<Live> other = live.lock()) other->go_on();
        });
      }
    }
    pass_on_work(visitor, number_, *hub_.pictures);
    for (const TrainingCommand command : visitor.host().take_training_commands())
      if (hub_.training != nullptr) hub_.training->command(command);
  }

  void ping() {
    socket_.async_ping(websocket::ping_data(kPing),
                       [self = shared_from_this()](error_code) { self->link_.ping_written(); });
  }

  void write(VisitorLink::Message message) {
    text_ = std::move(message.bytes);
    socket_.text(message.is_text);
    socket_.async_write(asio::buffer(text_),
                        [self = shared_from_this()](error_code error, std::size_t) {
                          if (error) return self->stop();
                          self->handle([](VisitorLink& link, double now) { link.written(now); });
                        });
  }

  void close(const VisitorLink::Close& close) {
    const auto code = static_cast<websocket::close_code>(close.code);
    socket_.async_close(websocket::close_reason(code, close.reason),
                        [self = shared_from_this()](error_code) { self->stop(); });
  }

  void wake_at(double time) {
    if (std::isinf(time)) return timer_.cancel(), void();
    const std::chrono::duration<double> since_epoch(time);
    // Ends an earlier wait with an error.
    timer_.expires_at(
        SteadyClock::time_point(std::chrono::duration_cast<SteadyClock::duration>(since_epoch)));
    timer_.async_wait([self = shared_from_this()](error_code error) {
      if (!error) self->go_on();
    });
  }

  void stop() {
    timer_.cancel();
    error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
    if (std::exchange(stopped_, true) || hub_.pictures == nullptr) return;
    hub_.pictures->forget(number_);
    const Visitor* const visitor = link_.last_visitor();
    if (visitor == nullptr || !visitor->viewer().crop.busy) return;
    const std::size_t scene = visitor->scene();
    hub_.pictures->run(kNobody, scene, show_crop(hub_.sharing.crop_of(scene)));
  }

  Hub& hub_;
  websocket::stream<ClientStream, false> socket_;  // without compression
  Place place_;
  int number_;
  VisitorLink link_;
  asio::steady_timer timer_;  // of VisitorLink::Step::wake_at
  beast::flat_buffer buffer_;
  std::string text_;  // the message that is being written
  bool stopped_ = false;
};

}  // namespace qs
