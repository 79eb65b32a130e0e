// SPDX-License-Identifier: MIT
//
// The bytes of a client's connection, encrypted or not: an AsyncStream of Boost.Beast over a
// tcp_stream, whose timeouts hold for both. Part of server.cpp.
#pragma once

#include <utility>  // Asio 1.74 uses std::exchange without it
#include <variant>

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

  /// Without a context the bytes are not encrypted. The context must outlive the stream.
  ClientStream(asio::ip::tcp::socket socket, [[maybe_unused]] TlsContext* context)
      : stream_(std::in_place_type<Plain>, std::move(socket)) {
#ifdef QUADSPLAT_TLS
    if (context != nullptr) replace<Encrypted>(*context);
#endif
  }

  /// Begins the encryption, if there is any. `done(error, is_http)`: the client speaks HTTP without
  /// encryption, and further bytes pass as they are.
  template <class Done>
  void async_begin(Done done) {
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
  template <class Done>
  void async_end(Done done) {
#ifdef QUADSPLAT_TLS
    if (auto* const encrypted = std::get_if<Encrypted>(&stream_))
      return encrypted->async_shutdown(std::move(done));
#endif
    done(error_code());
  }

  template <class Handler>
  void async_teardown(beast::role_type role, Handler&& handler) {
    using beast::websocket::async_teardown;
#ifdef QUADSPLAT_TLS
    if (auto* const encrypted = std::get_if<Encrypted>(&stream_))
      return encrypted->async_shutdown(std::forward<Handler>(handler));
#endif
    async_teardown(role, next_layer().socket(), std::forward<Handler>(handler));
  }

  executor_type get_executor() noexcept { return next_layer().get_executor(); }
  Plain& next_layer() noexcept {
    return std::visit([](auto& stream) -> Plain& { return beast::get_lowest_layer(stream); },
                      stream_);
  }

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    const auto read = [&](auto& stream) {
      stream.async_read_some(buffers, std::forward<Handler>(handler));
    };
    std::visit(read, stream_);
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    const auto write = [&](auto& stream) {
      stream.async_write_some(buffers, std::forward<Handler>(handler));
    };
    std::visit(write, stream_);
  }

 private:
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
template <class Handler>
void async_teardown(beast::role_type role, ClientStream& stream, Handler&& handler) {
  stream.async_teardown(role, std::forward<Handler>(handler));
}

}  // namespace qs
