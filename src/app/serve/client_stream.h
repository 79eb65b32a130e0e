// SPDX-License-Identifier: MIT
//
// The bytes of a client's connection, encrypted or not: an AsyncStream of Boost.Beast over a
// tcp_stream, whose timeouts hold for both. Part of server.cpp. Beast has a type for the handler of
// each of its operations. Here all of them become one type, so that the operations on a socket are
// compiled once.
#pragma once

#include <functional>
#include <memory>
#include <utility>  // Asio 1.74 uses std::exchange without it
#include <variant>
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket/teardown.hpp>
#ifdef QUADSPLAT_TLS
#include <boost/beast/ssl.hpp>
#include <openssl/err.h>
#endif

#include "app/serve/tls_context.h"

namespace qs {

namespace asio = boost::asio;
namespace beast = boost::beast;
using boost::system::error_code;

class ClientStream {
 public:
  using Plain = beast::tcp_stream;
#ifdef QUADSPLAT_TLS
  using Encrypted = beast::ssl_stream<Plain>;
#endif
  using executor_type = Plain::executor_type;
  using next_layer_type = Plain;
  template <class... Result>
  using Handler = std::function<void(error_code, Result...)>;

  /// Without a context the bytes are not encrypted. The context must outlive the stream.
  ClientStream(asio::ip::tcp::socket socket, [[maybe_unused]] TlsContext* context)
      : stream_(std::in_place_type<Plain>, std::move(socket)) {
#ifdef QUADSPLAT_TLS
    if (context != nullptr) replace<Encrypted>(*context);
#endif
  }

  /// Begins the encryption, if there is any. `done(error, is_http)`: the client speaks HTTP without
  /// encryption, and further bytes pass as they are.
  void async_begin(Handler<bool> done) {
#ifdef QUADSPLAT_TLS
    if (auto* const encrypted = std::get_if<Encrypted>(&stream_)) {
      return encrypted->async_handshake(
          asio::ssl::stream_base::server, [this, done = std::move(done)](error_code error) mutable {
            const bool is_http =
                error.category() == asio::error::get_ssl_category() &&
                ERR_GET_REASON(static_cast<unsigned long>(error.value())) == SSL_R_HTTP_REQUEST;
            if (is_http) replace<Plain>();
            done(error, is_http);
          });
    }
#endif
    done(error_code(), false);
  }

  /// Ends the encryption with a message, by which the client knows that nothing is missing.
  void async_end(Handler<> done) {
#ifdef QUADSPLAT_TLS
    if (auto* const encrypted = std::get_if<Encrypted>(&stream_))
      return encrypted->async_shutdown(std::move(done));
#endif
    done(error_code());
  }

  void async_teardown(beast::role_type role, Handler<> done) {
    using beast::websocket::async_teardown;
#ifdef QUADSPLAT_TLS
    if (auto* const encrypted = std::get_if<Encrypted>(&stream_))
      return encrypted->async_shutdown(std::move(done));
#endif
    async_teardown(role, next_layer().socket(), std::move(done));
  }

  executor_type get_executor() noexcept { return next_layer().get_executor(); }
  Plain& next_layer() noexcept {
    return std::visit([](auto& stream) -> Plain& { return beast::get_lowest_layer(stream); },
                      stream_);
  }

  template <class Buffers, class Done>
  void async_read_some(const Buffers& buffers, Done&& done) {
    const std::vector<asio::mutable_buffer> all(asio::buffer_sequence_begin(buffers),
                                                asio::buffer_sequence_end(buffers));
    read_some(all, handler<std::size_t>(std::forward<Done>(done)));
  }
  template <class Buffers, class Done>
  void async_write_some(const Buffers& buffers, Done&& done) {
    const std::vector<asio::const_buffer> all(asio::buffer_sequence_begin(buffers),
                                              asio::buffer_sequence_end(buffers));
    write_some(all, handler<std::size_t>(std::forward<Done>(done)));
  }

  /// A std::function holds only what can be copied. Handlers of Beast can only be moved, so it
  /// shares a pointer to the handler.
  template <class... Result, class Done>
  static Handler<Result...> handler(Done&& done) {
    return [done = std::make_shared<std::decay_t<Done>>(std::forward<Done>(done))](
               error_code error, Result... result) { std::move (*done)(error, result...); };
  }

 private:
  void read_some(const std::vector<asio::mutable_buffer>& buffers, Handler<std::size_t> done) {
    std::visit([&](auto& stream) { stream.async_read_some(buffers, std::move(done)); }, stream_);
  }
  void write_some(const std::vector<asio::const_buffer>& buffers, Handler<std::size_t> done) {
    std::visit([&](auto& stream) { stream.async_write_some(buffers, std::move(done)); }, stream_);
  }

  template <class Stream, class... Arguments>
  void replace(Arguments&... arguments) {
    Plain plain = std::move(next_layer());
    stream_.emplace<Stream>(std::move(plain), arguments...);
  }

#ifdef QUADSPLAT_TLS
  std::variant<Plain, Encrypted> stream_;
#else
  std::variant<Plain> stream_;
#endif
};

/// Called by Beast at the end of a WebSocket.
template <class Done>
void async_teardown(beast::role_type role, ClientStream& stream, Done&& done) {
  stream.async_teardown(role, ClientStream::handler<>(std::forward<Done>(done)));
}

}  // namespace qs
