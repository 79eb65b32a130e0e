// SPDX-License-Identifier: MIT
//
// A connection of a client from its first byte: encryption, the head of one request, and its answer
// or the WebSocket of a visitor. Part of server.cpp.
#pragma once

#include <array>

#include "app/serve/live.h"
#include "base/assets.h"
#include "base/error.h"
#include "io/bytes/mapped_file.h"

namespace qs {

namespace http = beast::http;

class Request : public std::enable_shared_from_this<Request> {
 public:
  Request(Hub& hub, asio::ip::tcp::socket socket, Place place)
      : hub_(hub),
        stream_(std::move(socket), hub.tls ? &*hub.tls : nullptr),
        place_(std::move(place)),
        timer_(hub.io) {
    parser_.header_limit(static_cast<std::uint32_t>(hub_.options.limits.head_bytes));
    parser_.body_limit(std::uint64_t{0});
  }

  /// Refuses the request unread if the place is of kind `leaving`.
  void begin() {
    timer_.expires_after(hub_.options.limits.head_time);
    timer_.async_wait([self = shared_from_this()](error_code error) {
      if (error) return;
      self->late_ = true;
      self->stream_.next_layer().cancel();
    });
    const bool is_refused = place_->kind() == ConnectionKind::leaving;
    stream_.async_begin([self = shared_from_this(), is_refused](error_code error, bool is_http) {
      if (is_http) return guarded(*self, [&] { self->refuse(400, "this port speaks https only"); });
      if (error) return self->timer_.cancel(), void();
      guarded(*self, [&] { is_refused ? self->refuse(503) : self->read(); });
    });
  }

  /// An exception ended a handler.
  void give_up() {
    timer_.cancel();
    error_code ignored;
    stream_.next_layer().socket().close(ignored);
  }

 private:
  static RequestHead head_of(const http::request<http::empty_body>& request) {
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
        status_of(head, hub_.tls ? "https" : "http", hub_.names, hub_.options.limits.target_bytes);
    if (status == 101) return open_live();
    if (status != 200) return refuse(status);
    send_file(*page_file(head.target));
  }

  void open_live() {
    if (hub_.connections.has_too_many_wrong_tokens(place_->address(), SteadyClock::now()))
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
      self->stream_.next_layer().socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
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

  /// For a refused client to read the answer.
  static constexpr std::chrono::milliseconds kLinger{1000};
  static constexpr std::size_t kMostDrained = 1 << 20;

  Hub& hub_;
  ClientStream stream_;
  Place place_;
  asio::steady_timer timer_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  http::response<http::string_body> response_;
  std::array<char, 4096> rest_{};
  std::size_t drained_ = 0;
  bool late_ = false;
};

}  // namespace qs
