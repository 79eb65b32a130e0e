// SPDX-License-Identifier: MIT
// Compiled alone: Boost takes long to compile, and it has macros of its own.
#ifdef QUADSPLAT_SERVE
#include "app/serve/live.h"

#include <cmath>

#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include "app/serve/served_training.h"
#include "app/viewer/render/upload_scene.h"

namespace qs {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Clock = std::chrono::steady_clock;

constexpr const char* kPing = "q";  ///< Beast pings with an empty text
constexpr int kNobody = 0;          ///< no visitor has this number

Clock::time_point time_of(double seconds) {
  return Clock::time_point(
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds)));
}

}  // namespace

Live::Live(Hub& hub, ClientStream stream, Place place)
    : hub_(hub),
      socket_(std::move(stream)),
      place_(std::move(place)),
      number_(hub.pictures->new_visitor()),
      link_({hub.options.limits, hub.options.token, hub.scenes, hub.sent}, seconds_now()),
      timer_(hub.io) {}

Live::~Live() {
  hub_.live.erase(number_);
  if (hub_.pictures != nullptr) hub_.pictures->forget(number_);
}

void Live::accept(const Head& request) {
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
  socket_.async_accept(request, [self = shared_from_this()](ErrorCode error) {
    if (error) return;
    self->hub_.live[self->number_] = self->weak_from_this();
    self->handle([](VisitorLink&, double) {});
    self->read();
  });
}

// Reads the next message.
void Live::read() {
  socket_.async_read(buffer_, [self = shared_from_this()](ErrorCode error, std::size_t) {
    if (error) return self->stop();
    guarded(*self, [&] { self->take(); });
  });
}

void Live::take() {
  const std::string text = beast::buffers_to_string(buffer_.data());
  buffer_.consume(buffer_.size());
  const VisitorLink::Taken taken = link_.take(text, socket_.got_binary(), seconds_now());
  if (taken == VisitorLink::Taken::wrong_token)
    hub_.connections.note_wrong_token(place_->address(), Clock::now());
  if (taken == VisitorLink::Taken::hello) greet();
  proceed();
  if (!link_.is_closing()) read();
}

void Live::greet() {
  if (!place_->move_to(ConnectionKind::visitor))
    return link_.close(CloseCode::try_later, "too many visitors");
  if (hub_.training != nullptr) link_.visitor()->apply({hub_.training->greeting()}, seconds_now());
}

void Live::give_up() {
  try {
    link_.close(CloseCode::failed, "the server cannot go on with this visitor");
    proceed();
  } catch (const std::exception&) {
    stop();
  }
}

// Does what the link says.
void Live::proceed() {
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
void Live::pass_on(Visitor& visitor) {
  if (hub_.sharing.meet(visitor, seconds_now())) {
    for (const auto& [number, live] : hub_.live) {
      if (number == number_) continue;
      asio::post(hub_.io, [live = live] {
        if (const std::shared_ptr<Live> other = live.lock())
          other->handle([](VisitorLink&, double) {});
      });
    }
  }
  pass_on_work(visitor, number_, *hub_.pictures);
  for (const TrainingCommand command : visitor.take_training_commands()) {
    if (hub_.training != nullptr) hub_.training->command(command);
  }
}

void Live::ping() {
  socket_.async_ping(websocket::ping_data(kPing),
                     [self = shared_from_this()](ErrorCode) { self->link_.ping_written(); });
}

void Live::write(VisitorLink::Message message) {
  text_ = std::move(message.bytes);
  socket_.text(message.is_text);
  socket_.async_write(asio::buffer(text_),
                      [self = shared_from_this()](ErrorCode error, std::size_t) {
                        if (error) return self->stop();
                        self->handle([](VisitorLink& link, double now) { link.written(now); });
                      });
}

void Live::close(const VisitorLink::Close& close) {
  const auto code = static_cast<websocket::close_code>(close.code);
  socket_.async_close(websocket::close_reason(code, close.reason),
                      [self = shared_from_this()](ErrorCode) { self->stop(); });
}

void Live::wake_at(double time) {
  if (std::isinf(time)) return timer_.cancel(), void();
  timer_.expires_at(time_of(time));  // ends an earlier wait with an error
  timer_.async_wait([self = shared_from_this()](ErrorCode error) {
    if (!error) self->handle([](VisitorLink&, double) {});
  });
}

void Live::stop() {
  timer_.cancel();
  ErrorCode ignored;
  beast::get_lowest_layer(socket_).socket().close(ignored);
  if (std::exchange(stopped_, true) || hub_.pictures == nullptr) return;
  hub_.pictures->forget(number_);
  const Visitor* const visitor = link_.last_visitor();
  if (visitor == nullptr || !visitor->viewer().crop.busy) return;
  const std::size_t scene = visitor->scene();
  hub_.pictures->run(kNobody, scene, show_crop(hub_.sharing.crop_of(scene)));
}

}  // namespace qs

#endif
