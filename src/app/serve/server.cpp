// SPDX-License-Identifier: MIT
// Compiled alone: Boost takes long to compile, and it has macros of its own.
//
// Only this file, client_stream.h and tls_context.h include Boost. Everything here runs on the
// thread of Server::run().
#include "app/serve/server.h"

#ifdef QUADSPLAT_SERVE
#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <map>
#include <optional>
#include <utility>  // Asio 1.74 uses std::exchange without it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <fmt/format.h>

#include "app/serve/client_stream.h"
#include "app/serve/connections.h"
#include "app/serve/flow.h"
#include "app/serve/picture_message.h"
#include "app/serve/requests.h"
#include "app/serve/served_training.h"
#include "app/serve/sharing.h"
#include "app/serve/state_json.h"
#include "app/serve/token.h"
#include "app/viewer/render/crop_scene.h"
#include "base/assets.h"
#include "io/bytes/mapped_file.h"
#endif

#include "base/fail.h"

namespace qs {

#ifndef QUADSPLAT_SERVE

class Server::Network {};

Server::Server(const ServeOptions& options) {
  fail(ErrorKind::device,
       "{}: this program was built without its web server: install libboost-dev and build it again",
       options.command);
}
Server::~Server() = default;
int Server::port() const { return 0; }
std::vector<std::string> Server::warnings() const { return {}; }
int Server::sibr_port() const { return 0; }
const std::array<SentPictures, 4>& Server::sent() const {
  static const std::array<SentPictures, 4> kNone;
  return kNone;
}
void Server::run(ServedScenes&, const std::function<bool()>&, ServedTraining*) {}

#else

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using Tcp = asio::ip::tcp;
using Clock = std::chrono::steady_clock;
using Timer = asio::steady_timer;

constexpr std::chrono::milliseconds kTurn{16};        ///< of a visitor whose camera moves
constexpr std::chrono::milliseconds kPingTime{1000};  ///< between two empty messages at least
constexpr std::chrono::milliseconds kStateTime{100};  ///< between two states at least
constexpr std::chrono::milliseconds kLinger{1000};    ///< for a refused client to read the answer
constexpr std::chrono::milliseconds kEndTurn{100};    ///< between two questions whether to end
constexpr const char* kPing = "q";                    ///< differs from the empty one of Beast
constexpr int kMostInWork = 2;                        ///< pictures of a visitor: one is encoded
constexpr int kNobody = 0;                            ///< the number of no visitor
constexpr std::uint16_t kWrongToken = 4401, kTryLater = 1013, kFailed = 1011, kTooMany = 1008,
                        kNoJson = 1007, kBinary = 1003;

double seconds_of(Clock::time_point time) {
  return std::chrono::duration<double>(time.time_since_epoch()).count();
}
double seconds_now() { return seconds_of(Clock::now()); }
Clock::time_point time_of(double seconds) {
  return Clock::time_point(
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds)));
}
Clock::duration of_ms(double ms) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::milli>(ms));
}

class Live;

/// The state that all connections share.
struct Hub {
  ServeOptions options;
  HostNames names{"", ""};
  std::optional<TlsContext> tls;
  Connections connections{options.limits};
  std::map<int, std::weak_ptr<Live> > live;  // by visitor
  std::vector<const OpenedScene*> scenes;
  Pictures* pictures = nullptr;
  ServedTraining* training = nullptr;
  Sharing sharing;
  std::array<SentPictures, 4> sent;
  asio::io_context io;  // goes first and takes the connections with it, which use the rest

  std::string_view scheme() const { return tls ? "https" : "http"; }
};

using Place = std::unique_ptr<Connections::Place>;

// Runs the work of a handler. An exception ends its owner, and not the server.
template <class Owner, class Work>
void guarded(Owner& owner, Work&& work) {
  try {
    work();
  } catch (const std::exception&) {
    owner.give_up();
  }
}

// ---- a visitor's WebSocket ----------------------------------------------------------------------
class Live : public std::enable_shared_from_this<Live> {
 public:
  Live(Hub& hub, ClientStream stream, Place place)
      : hub_(hub),
        socket_(std::move(stream)),
        place_(std::move(place)),
        number_(hub.pictures->new_visitor()),
        token_timer_(hub.io),
        turn_timer_(hub.io),
        order_timer_(hub.io),
        state_timer_(hub.io),
        write_timer_(hub.io) {}
  ~Live() {
    hub_.live.erase(number_);
    if (hub_.pictures != nullptr) hub_.pictures->forget(number_);
  }

  void accept(const http::request<http::empty_body>& request) {
    const ServeLimits& limits = hub_.options.limits;
    beast::get_lowest_layer(socket_).expires_never();
    socket_.set_option(websocket::stream_base::timeout{limits.head_time, limits.pong_time, true});
    socket_.read_message_max(limits.message_bytes);
    socket_.control_callback([this](websocket::frame_type kind, beast::string_view payload) {
      if (kind == websocket::frame_type::pong && payload == kPing) take_pong();
      if (kind == websocket::frame_type::close) guard_write();  // the end may take no longer
    });
    socket_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (!error) guarded(*self, [&] { self->begin(); });
    });
  }

  /// An exception ended a handler.
  void give_up() {
    try {
      close(kFailed, "the server cannot go on with this visitor");
    } catch (const std::exception&) {
      stop();
    }
  }

  void end() {
    error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
  }

  // The next picture may be rendered while this one is encoded, but not sooner than needed for it
  // to be encoded next.
  void picture_drawn() {
    renders_ = false;
    next_order_ = std::max(next_order_, Clock::now() + encoding_time_ - rendering_time_);
    proceed();
  }

  void picture_ready(Picture picture) {
    if (picture.is_last) --in_work_;
    if (!picture.order.lossless) {
      rendering_time_ = of_ms(static_cast<double>(picture.shown.stats.frame_ms));
      encoding_time_ = of_ms(picture.encoded.ms);
      making_time_ = of_ms(1e3 * (seconds_now() - picture.order.ordered));
    }
    if (picture.is_last) visitor_->picture_ready(picture, seconds_now());
    const bool stale = picture.order.lossless && visitor_->has_moved_on();
    if (!picture.encoded.bytes.empty() && !stale) outgoing_.push_back(std::move(picture));
    proceed();
  }

  // No actions: the job has ended.
  void job_reported(const Actions& actions) {
    if (actions.empty()) visitor_->job_ended();
    visitor_->apply(actions, seconds_now());
    proceed();
  }

  void measuring_changed(int version, Measuring state) {
    visitor_->measuring_changed(version, state, seconds_now());
    proceed();
  }

  // Actions for all visitors.
  void tell(const Actions& actions) {
    if (!visitor_ || stopped_) return;
    guarded(*this, [&] {
      visitor_->apply(actions, seconds_now());
      proceed();
    });
  }

  // Does what is due, for example after another visitor changed the crop or the backend.
  void follow() {
    guarded(*this, [&] { proceed(); });
  }

 private:
  void begin() {
    hub_.live[number_] = weak_from_this();
    const ServeLimits& limits = hub_.options.limits;
    token_timer_.expires_after(limits.token_time);
    token_timer_.async_wait([self = shared_from_this()](error_code error) {
      if (!error && !self->visitor_) self->close(kWrongToken, "no token");
    });
    read();
  }

  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->stop();
      guarded(*self, [&] {
        if (self->take()) self->read();
      });
    });
  }

  // False after the connection was closed.
  bool take() {
    if (socket_.got_binary()) return close(kBinary, "text only");
    if (!is_within_rate()) return close(kTooMany, "too many messages");
    const std::string text = beast::buffers_to_string(buffer_.data());
    buffer_.consume(buffer_.size());
    const std::optional<ClientMessage> message = parse_message(text);
    if (!message) return close(kNoJson, "not a message of this page");
    if (const auto* hello = std::get_if<message::Hello>(&message->body)) return greet(*hello);
    if (!visitor_) return refuse_token();
    if (const auto* received = std::get_if<message::Received>(&message->body)) {
      // A new confirmation answers a message of the server, so the flow limits their number.
      if (received->count != flow_.received()) --messages_;
      if (!flow_.received(received->count, received->held / 1000, seconds_now()))
        return close(kTooMany, "wrong count");
    } else {
      visitor_->take(*message, seconds_now());
    }
    proceed();
    return true;
  }

  bool is_within_rate() {
    const Clock::time_point now = Clock::now();
    if (now - second_began_ >= std::chrono::seconds(1)) {
      second_began_ = now;
      messages_ = 0;
    }
    return ++messages_ <= hub_.options.limits.messages_per_second;
  }

  bool greet(const message::Hello& hello) {
    if (visitor_) return close(kTooMany, "a second hello");
    if (!same_token(hub_.options.token, hello.token)) return refuse_token();
    if (!place_->move_to(ConnectionKind::visitor)) return close(kTryLater, "too many visitors");
    token_timer_.cancel();
    visitor_.emplace(hub_.scenes, hello.size, seconds_now());
    if (hub_.training != nullptr) visitor_->apply({hub_.training->greeting()}, seconds_now());
    ping();  // before the state, which takes its time
    proceed();
    return true;
  }

  bool refuse_token() {
    hub_.connections.note_wrong_token(place_->address(), Clock::now());
    return close(kWrongToken, "wrong token");
  }

  // Always false. A message that is being sent is finished first.
  bool close(std::uint16_t code, const char* reason) {
    if (closing_) return false;
    closing_ = websocket::close_reason(static_cast<websocket::close_code>(code), reason);
    turn_timer_.cancel();
    if (!writing_) send_close();
    return false;
  }

  void send_close() {
    guard_write();
    writing_ = true;
    socket_.async_close(*closing_, [self = shared_from_this()](error_code) { self->stop(); });
  }

  void stop() {
    token_timer_.cancel();
    turn_timer_.cancel();
    order_timer_.cancel();
    state_timer_.cancel();
    write_timer_.cancel();
    if (!stopped_) leave();
    stopped_ = true;
    end();
  }

  void leave() {
    if (hub_.pictures == nullptr) return;
    hub_.pictures->forget(number_);
    if (!visitor_ || !visitor_->viewer().crop.busy) return;
    const std::size_t scene = visitor_->scene();
    hub_.pictures->run(kNobody, scene, show_crop(hub_.sharing.crop_of(scene)));
  }

  // Does what is due: orders a picture, sends, waits for the next turn.
  void proceed() {
    if (stopped_ || closing_ || !visitor_) return;
    share();
    pass_on_work();
    const bool moved_on = visitor_->has_moved_on();
    if (moved_on && in_work_ > 0) hub_.pictures->cancel_lossless(number_);
    if (moved_on) drop_lossless();
    waits_to_order_ = false;
    const int coming = in_work_ + static_cast<int>(outgoing_.size());
    if (!renders_ && in_work_ < kMostInWork) order_picture(coming);
    send();
    await_turn();
    await_order();
  }

  // Moving pictures are all sent, because each refers to the picture before it.
  void drop_lossless() {
    if (!outgoing_.empty() && outgoing_.front().order.lossless) sent_bytes_ = 0;
    std::erase_if(outgoing_, [](const Picture& picture) { return picture.order.lossless; });
  }

  // Follows the other visitors, or makes them follow.
  void share() {
    if (!hub_.sharing.meet(*visitor_, seconds_now())) return;
    for (const auto& [number, live] : hub_.live) {
      if (number == number_) continue;
      asio::post(hub_.io, [live] {
        if (const std::shared_ptr<Live> other = live.lock()) other->follow();
      });
    }
  }

  // Jobs, measuring and files that the visitor's actions ask for.
  void pass_on_work() {
    if (visitor_->take_stop()) hub_.pictures->stop_long(number_);
    for (const TrainingCommand command : visitor_->take_training_commands()) {
      if (hub_.training != nullptr) hub_.training->command(command);
    }
    const std::size_t scene = visitor_->scene();
    for (VisitorJob& work : visitor_->take_jobs()) {
      if (work.is_long) {
        hub_.pictures->run_long(number_, scene, std::move(work.job));
      } else {
        hub_.pictures->run(number_, scene, std::move(work.job));
      }
    }
    const MeasuringWish wish = visitor_->measuring_wish();
    if (wish.stops) hub_.pictures->stop_measuring(number_);
    if (wish.request) hub_.pictures->measure({number_, scene, *wish.request});
    for (SentFile& file : visitor_->take_files()) files_.push_back(std::move(file));
  }

  // At most one picture per turn, because a screen shows no more. While the line has no room, a
  // picture is made so that it is ready when a confirmation makes room.
  void order_picture(int coming) {
    order_due_ = next_order_;
    if (!flow_.has_room(coming)) {
      const std::optional<double> room = flow_.next_room(coming);
      if (!room) return;
      order_due_ = std::max(order_due_, time_of(*room) - making_time_);
    }
    const Clock::time_point now = Clock::now();
    waits_to_order_ = now < order_due_;
    if (waits_to_order_) return;
    next_order_ = now + kTurn;
    if (std::optional<PictureOrder> order = visitor_->next_order(flow_.speed())) {
      order->ordered = seconds_of(now);
      renders_ = true;
      ++in_work_;
      hub_.pictures->order(number_, std::move(*order));
    }
  }

  void tick() {
    guarded(*this, [&] {
      visitor_->tick(seconds_now());
      proceed();
    });
  }

  void await_turn() {
    if (waits_for_turn_ || !visitor_->is_busy()) return;
    waits_for_turn_ = true;
    turn_timer_.expires_after(kTurn);
    turn_timer_.async_wait([self = shared_from_this()](error_code error) {
      self->waits_for_turn_ = false;
      if (!error) self->tick();
    });
  }

  void await_order() {
    if (!waits_to_order_ || (waits_for_order_ && order_timer_.expiry() <= order_due_)) return;
    waits_for_order_ = true;
    order_timer_.expires_at(order_due_);  // ends an earlier wait with an error
    order_timer_.async_wait([self = shared_from_this()](error_code error) {
      if (error) return;
      self->waits_for_order_ = false;
      self->tick();
    });
  }

  void send() {
    if (writing_) return;
    if (send_state()) return;
    if (outgoing_.empty()) return send_file();
    const Picture& picture = outgoing_.front();
    const std::size_t end = end_of_part(picture, sent_bytes_);
    const bool lossless = picture.order.lossless;
    if (lossless ? !flow_.has_room_for_part(end - sent_bytes_) : !flow_.has_room()) return;
    ping();
    const auto since =
        std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch());
    if (sent_bytes_ == 0 && picture.top == 0) ++picture_;
    SentPictures& sent = hub_.sent[static_cast<std::size_t>(picture.encoded.codec)];
    if (sent_bytes_ == 0) {
      sent.pictures += picture.top == 0 ? 1 : 0;
      sent.bytes += picture.encoded.bytes.size();
      sent.encode_ms += picture.encoded.ms;
    }
    text_ = picture_message(
        picture, {picture_, version_, static_cast<std::uint64_t>(since.count())}, sent_bytes_);
    sent_bytes_ = end;
    flow_.sent(seconds_now(), text_.size(), lossless);
    if (end == picture.encoded.bytes.size()) {
      outgoing_.pop_front();
      sent_bytes_ = 0;
    }
    socket_.binary(true);
    write(&sent);
  }

  // An empty message before pictures. Its round trip is the least one of the line.
  void ping() {
    const Clock::time_point now = Clock::now();
    if (pings_ || writes_ping_ || now < next_ping_) return;
    pings_ = writes_ping_ = true;
    pinged_ = now;
    next_ping_ = now + kPingTime;
    pinged_alone_ = flow_.is_empty();
    socket_.async_ping(websocket::ping_data(kPing),
                       [self = shared_from_this()](error_code) { self->writes_ping_ = false; });
  }
  void take_pong() {
    if (pings_) flow_.round_trip(seconds_of(Clock::now()) - seconds_of(pinged_), pinged_alone_);
    pings_ = false;
  }

  void send_file() {
    if (files_.empty()) return;
    const SentFile& file = files_.front();
    const std::size_t end = std::min(sent_of_file_ + kFilePart, file.bytes->size());
    if (!flow_.has_room_for_part(end - sent_of_file_)) return;
    text_ = file_message(file, file_, sent_of_file_);
    sent_of_file_ = end;
    if (sent_of_file_ == file.bytes->size()) {
      files_.pop_front();
      sent_of_file_ = 0;
      ++file_;
    }
    flow_.sent(seconds_now(), text_.size(), true);
    socket_.binary(true);
    write();
  }

  // True if a state is being sent.
  bool send_state() {
    const Clock::time_point now = Clock::now();
    if (now < next_state_) {
      await_state();
      return false;
    }
    StateSections sections = state_sections(*visitor_, hub_.scenes);
    std::string message = state_message(sections_, sections, version_ + 1);
    next_state_ = now + kStateTime;
    if (message.empty()) return false;
    ++version_;
    sections_ = std::move(sections);
    text_ = std::move(message);
    socket_.text(true);
    write();
    return true;
  }

  // The state may have changed since it was sent, and nothing else may happen.
  void await_state() {
    if (waits_for_state_) return;
    waits_for_state_ = true;
    state_timer_.expires_at(next_state_);
    state_timer_.async_wait([self = shared_from_this()](error_code error) {
      self->waits_for_state_ = false;
      if (!error) self->follow();
    });
  }

  void guard_write() {
    write_timer_.expires_after(hub_.options.limits.write_time);
    write_timer_.async_wait([self = shared_from_this()](error_code error) {
      if (!error) self->stop();
    });
  }

  // `sent`: counts the time; may be null.
  void write(SentPictures* sent = nullptr) {
    writing_ = true;
    guard_write();
    const double began = seconds_now();
    socket_.async_write(asio::buffer(text_),
                        [self = shared_from_this(), sent, began](error_code error, std::size_t) {
                          if (sent != nullptr) sent->send_ms += 1e3 * (seconds_now() - began);
                          self->writing_ = false;
                          self->write_timer_.cancel();
                          if (error) return self->stop();
                          if (self->closing_) return self->send_close();
                          self->follow();
                        });
  }

  Hub& hub_;
  websocket::stream<ClientStream> socket_;
  Place place_;
  int number_;
  Timer token_timer_, turn_timer_, order_timer_, state_timer_, write_timer_;
  beast::flat_buffer buffer_;
  std::optional<Visitor> visitor_;  // set by the right token
  PictureFlow flow_;
  StateSections sections_;     // as the page has them
  std::uint32_t version_ = 0;  // of the state
  Clock::time_point next_state_{}, next_order_{}, second_began_{};
  Clock::time_point pinged_{}, next_ping_{};
  Clock::duration rendering_time_{}, encoding_time_{};  // of the last moving picture
  Clock::duration making_time_{};                       // of it, from the order to its bytes
  Clock::time_point order_due_{};
  int messages_ = 0;  // in this second
  int in_work_ = 0;   // pictures that were ordered
  bool renders_ = false, writing_ = false, stopped_ = false;
  bool pings_ = false;        // no answer has come
  bool writes_ping_ = false;  // a page may answer before it: Beast writes one ping at a time
  bool pinged_alone_ = false;
  bool waits_for_turn_ = false, waits_for_state_ = false, waits_for_order_ = false;
  bool waits_to_order_ = false;  // until order_due_
  std::optional<websocket::close_reason> closing_;
  std::deque<Picture> outgoing_;
  std::size_t sent_bytes_ = 0;  // of the first of them
  std::uint32_t picture_ = 0;   // number of the last picture that was sent
  std::deque<SentFile> files_;
  std::size_t sent_of_file_ = 0;  // bytes of the first
  std::uint32_t file_ = 0;        // number
  std::string text_;              // the message that is being sent
};

// ---- a request ----------------------------------------------------------------------------------
RequestHead head_of(const http::request<http::empty_body>& request) {
  RequestHead head;
  head.method = std::string(request.method_string());
  head.target = std::string(request.target());
  for (const auto& field : request) {
    if (field.name() == http::field::host) head.hosts.emplace_back(field.value());
    if (field.name() == http::field::origin) head.origins.emplace_back(field.value());
  }
  head.upgrades = websocket::is_upgrade(request);
  return head;
}

class Request : public std::enable_shared_from_this<Request> {
 public:
  Request(Hub& hub, Tcp::socket socket, Place place)
      : hub_(hub),
        stream_(std::move(socket), hub.tls ? &*hub.tls : nullptr),
        place_(std::move(place)),
        timer_(hub.io) {
    const ServeLimits& limits = hub_.options.limits;
    parser_.header_limit(static_cast<std::uint32_t>(limits.head_bytes));
    parser_.body_limit(std::uint64_t{0});
  }

  /// `refusal`: the status with which the request is refused unread; 0: it is read.
  void begin(unsigned refusal) {
    timer_.expires_after(hub_.options.limits.head_time);
    timer_.async_wait([self = shared_from_this()](error_code error) {
      if (error) return;
      self->late_ = true;
      self->stream_.next_layer().cancel();
    });
    stream_.async_begin([self = shared_from_this(), refusal](error_code error, bool is_http) {
      if (is_http) return guarded(*self, [&] { self->refuse(400, "this port speaks https only"); });
      if (error) return self->timer_.cancel(), void();
      guarded(*self, [&] { refusal != 0 ? self->refuse(refusal) : self->read(); });
    });
  }

  /// An exception ended a handler.
  void give_up() {
    timer_.cancel();
    error_code ignored;
    stream_.next_layer().socket().close(ignored);
  }

 private:
  void read() {
    http::async_read_header(stream_, buffer_, parser_,
                            [self = shared_from_this()](error_code error, std::size_t) {
                              guarded(*self, [&] { self->answer(error); });
                            });
  }

  void send(unsigned status, std::string body, const char* type) {
    timer_.cancel();
    response_.version(11);
    response_.result(status);
    for (const HeaderField& field : security_fields()) response_.set(field.name, field.value);
    response_.set(http::field::content_type, type);
    if (status == 405) response_.set(http::field::allow, "GET");
    response_.keep_alive(false);
    response_.body() = std::move(body);
    response_.prepare_payload();
    stream_.next_layer().expires_after(hub_.options.limits.write_time);
    http::async_write(stream_, response_,
                      [self = shared_from_this()](error_code error, std::size_t) {
                        if (!error) guarded(*self, [&] { self->linger(); });
                      });
  }

  void refuse(unsigned status) {
    refuse(status, std::string(http::obsolete_reason(static_cast<http::status>(status))));
  }
  void refuse(unsigned status, const std::string& sentence) {
    send(status, sentence + "\n", "text/plain; charset=utf-8");
  }

  void answer(error_code error) {
    timer_.cancel();
    if (late_) return refuse(408);
    if (error == http::error::header_limit) return refuse(431);
    if (error == http::error::body_limit) return refuse(413);
    if (error.category() == http::make_error_code(http::error::end_of_stream).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message)
      return refuse(400);
    if (error) return;
    const auto& request = parser_.get();
    if (parser_.chunked() || parser_.content_length().value_or(0) > 0) return refuse(413);
    const RequestHead head = head_of(request);
    const unsigned status =
        status_of(head, hub_.scheme(), hub_.names, hub_.options.limits.target_bytes);
    if (status == 101) return open_live();
    if (status != 200) return refuse(status);
    send_file(*page_file(head.target));
  }

  void open_live() {
    if (hub_.connections.has_too_many_wrong_tokens(place_->address(), Clock::now()))
      return refuse(429);
    std::make_shared<Live>(hub_, std::move(stream_), std::move(place_))->accept(parser_.get());
  }

  void send_file(const PageFile& file) {
    const auto path = find_asset(file.asset);
    if (!path) return refuse(500);
    try {
      const MappedFile content(*path);
      const auto bytes = content.content();
      send(200, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, file.type);
    } catch (const Error&) {
      refuse(500);
    }
  }

  // Unread input at the end would discard the answer, so it is read for a moment.
  void linger() {
    if (!place_->move_to(ConnectionKind::leaving)) return;
    stream_.next_layer().expires_after(kLinger);
    stream_.async_end([self = shared_from_this()](error_code) {
      error_code ignored;
      self->stream_.next_layer().socket().shutdown(Tcp::socket::shutdown_send, ignored);
      self->stream_.next_layer().expires_after(kLinger);
      self->drain();
    });
  }
  void drain() {
    stream_.next_layer().async_read_some(
        asio::buffer(rest_), [self = shared_from_this()](error_code error, std::size_t bytes) {
          self->drained_ += bytes;
          if (!error && self->drained_ < kMostDrained) self->drain();
        });
  }

  static constexpr std::size_t kMostDrained = 1 << 20;

  Hub& hub_;
  ClientStream stream_;
  Place place_;
  Timer timer_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  http::response<http::string_body> response_;
  std::array<char, 4096> rest_{};
  std::size_t drained_ = 0;
  bool late_ = false;
};

}  // namespace

// ---- the server ---------------------------------------------------------------------------------
class Server::Network {
 public:
  explicit Network(const ServeOptions& options)
      : acceptor_(hub_.io), end_timer_(hub_.io), accept_timer_(hub_.io) {
    hub_.options = options;
    if (options.tls) hub_.tls.emplace(make_tls_context(*options.tls, options.command));
    hub_.names = HostNames(options.address, options.name);
    error_code error;
    const auto address = asio::ip::make_address(options.address, error);
    if (error)
      fail(ErrorKind::usage, "{}: --address {}: not an address such as 127.0.0.1 or ::1",
           options.command, options.address);
    const Tcp::endpoint endpoint(address, static_cast<unsigned short>(options.port));
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(Tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (error) {
      fail(ErrorKind::device, "{}: {} port {} cannot be used: {}", options.command, options.address,
           options.port, error.message());
    }
    if (options.sibr) sibr_listener_ = listen_for_sibr(*options.sibr);
  }

  int port() const { return acceptor_.local_endpoint().port(); }
  std::vector<std::string> warnings() const {
    std::vector<std::string> sentences;
    const ServeOptions& options = hub_.options;
    if (!hub_.tls && !acceptor_.local_endpoint().address().is_loopback()) {
      sentences.push_back(
          fmt::format("{} can be reached from other machines, and the connection is not encrypted: "
                      "ssh -L to 127.0.0.1 is safer, or --certificate and --key",
                      options.address));
    }
    if (!hub_.tls) return sentences;
    const std::string problem = certificate_problem(*hub_.tls);
    if (!problem.empty()) {
      sentences.push_back(fmt::format("{}: --certificate {}: {}; browsers refuse it",
                                      options.command, options.tls->certificate.string(), problem));
    }
    return sentences;
  }
  int sibr_port() const { return sibr_listener_.port(); }
  const std::array<SentPictures, 4>& sent() const { return hub_.sent; }

  void run(ServedScenes& scenes, const std::function<bool()>& ends, ServedTraining* training) {
    hub_.training = training;
    for (const auto& scene : scenes) hub_.scenes.push_back(&scene->opened);
    {
      Pictures pictures(
          scenes,
          {[this](int visitor) { to_live(visitor, [](Live& live) { live.picture_drawn(); }); },
           [this](int visitor, Picture picture) {
             to_live(visitor, [picture = std::move(picture)](Live& live) mutable {
               live.picture_ready(std::move(picture));
             });
           },
           [this](int visitor, Actions actions) {
             if (reported_by_training(visitor, actions)) return;
             to_live(visitor,
                     [actions = std::move(actions)](Live& live) { live.job_reported(actions); });
           },
           [this](int visitor, int version, Measuring state) {
             to_live(visitor,
                     [version, state](Live& live) { live.measuring_changed(version, state); });
           }});
      hub_.pictures = &pictures;
      std::optional<SibrServer> sibr;
      if (hub_.options.sibr)
        sibr.emplace(sibr_listener_, *hub_.options.sibr, pictures, *hub_.scenes.front());
      await_end(ends);
      accept();
      hub_.io.run();
      hub_.pictures = nullptr;
    }
    hub_.io.restart();
  }

  /// An exception ended a handler of no visitor. The next turn tries again.
  void give_up() {}

 private:
  // Calls the function with the visitor's connection on the thread of the network, if it still
  // exists.
  template <class Function>
  void to_live(int visitor, Function function) {
    asio::post(hub_.io, [this, visitor, function = std::move(function)]() mutable {
      const auto found = hub_.live.find(visitor);
      if (found == hub_.live.end()) return;
      if (const std::shared_ptr<Live> live = found->second.lock())
        guarded(*live, [&] { function(*live); });
    });
  }

  void accept() {
    acceptor_.async_accept([this](error_code error, Tcp::socket socket) {
      if (!acceptor_.is_open()) return;
      if (error) return accept_later();
      guarded(*this, [&] { begin(std::move(socket)); });
      accept();
    });
  }

  // For example without file descriptors.
  void accept_later() {
    accept_timer_.expires_after(kEndTurn);
    accept_timer_.async_wait([this](error_code error) {
      if (!error) accept();
    });
  }

  void begin(Tcp::socket socket) {
    error_code error;
    const auto remote = socket.remote_endpoint(error);
    if (error) return;
    socket.set_option(Tcp::no_delay(true), error);
    Place place = hub_.connections.enter(remote.address().to_string());
    if (!place) return;
    const unsigned refusal = place->kind() == ConnectionKind::request ? 0 : 503;
    std::make_shared<Request>(hub_, std::move(socket), std::move(place))->begin(refusal);
  }

  // All visitors share the model of a training. The thread of the renderer calls this too.
  bool reported_by_training(int visitor, const Actions& actions) {
    if (hub_.training == nullptr || visitor != hub_.training->visitor()) return false;
    asio::post(hub_.io, [this, actions] {
      guarded(*this, [&] {
        hub_.training->job_reported(actions);
        tell_all(actions);
      });
    });
    return true;
  }
  void tell_all(const Actions& actions) {
    if (actions.empty()) return;
    const auto all = hub_.live;  // a visitor may leave meanwhile
    for (const auto& [number, weak] : all) {
      if (const std::shared_ptr<Live> live = weak.lock()) live->tell(actions);
    }
  }
  void follow_training() {
    if (hub_.training != nullptr)
      tell_all(hub_.training->follow(*hub_.pictures, !hub_.live.empty(), seconds_now()));
  }

  void await_end(const std::function<bool()>& ends) {
    bool is_over = false;
    guarded(*this, [&] {
      hub_.connections.prune(Clock::now());
      follow_training();
      is_over = ends();
    });
    if (is_over) {
      error_code ignored;
      acceptor_.close(ignored);
      hub_.io.stop();
      return;
    }
    end_timer_.expires_after(kEndTurn);
    end_timer_.async_wait([this, &ends](error_code error) {
      if (!error) await_end(ends);
    });
  }

  Hub hub_;
  Tcp::acceptor acceptor_;
  TcpSocket sibr_listener_;
  Timer end_timer_, accept_timer_;
};

Server::Server(const ServeOptions& options) : network_(std::make_unique<Network>(options)) {}
Server::~Server() = default;
int Server::port() const { return network_->port(); }
std::vector<std::string> Server::warnings() const { return network_->warnings(); }
int Server::sibr_port() const { return network_->sibr_port(); }
const std::array<SentPictures, 4>& Server::sent() const { return network_->sent(); }
void Server::run(ServedScenes& scenes, const std::function<bool()>& ends,
                 ServedTraining* training) {
  network_->run(scenes, ends, training);
}

#endif

}  // namespace qs
