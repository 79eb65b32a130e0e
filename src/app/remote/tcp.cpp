// SPDX-License-Identifier: MIT
#include "app/remote/tcp.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/fail.h"

namespace qs {
namespace {

using TcpClock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kSlice{50};  ///< of a wait, between two looks at its stop
constexpr int kBacklog = 8;

// Waits until the socket can be read from or written to.
TcpEnd await(int descriptor, short events, const Patience& patience) {
  while (!patience.stop.stop_requested()) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(patience.end - TcpClock::now());
    const auto slice = std::clamp(left, std::chrono::milliseconds(0), kSlice);
    pollfd waiting{descriptor, events, 0};
    const int count = ::poll(&waiting, 1, static_cast<int>(slice.count()));
    if (count > 0) return TcpEnd::done;
    if (count < 0 && errno != EINTR) return TcpEnd::closed;
    if (count == 0 && left <= slice) return TcpEnd::late;
  }
  return TcpEnd::stopped;
}

bool is_again(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

// Without delay for small messages, and without waiting in calls.
TcpSocket prepared(int descriptor) {
  TcpSocket socket(descriptor);
  if (!socket.is_open()) return socket;
  const int on = 1;
  ::setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL) | O_NONBLOCK);
  return socket;
}

}  // namespace

Patience patience(std::chrono::milliseconds time, std::stop_token stop) {
  return {TcpClock::now() + time, std::move(stop)};
}

TcpEnd TcpSocket::read(std::span<std::byte> bytes, const Patience& patience) {
  while (!bytes.empty()) {
    if (const TcpEnd end = await(descriptor(), POLLIN, patience); end != TcpEnd::done) return end;
    const ssize_t count = ::recv(descriptor(), bytes.data(), bytes.size(), 0);
    if (count < 0 && is_again(errno)) continue;
    if (count <= 0) return TcpEnd::closed;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return TcpEnd::done;
}

TcpEnd TcpSocket::await_bytes(const Patience& patience) {
  return await(descriptor(), POLLIN, patience);
}

TcpEnd TcpSocket::write(std::span<const std::byte> bytes, const Patience& patience) {
  while (!bytes.empty()) {
    if (const TcpEnd end = await(descriptor(), POLLOUT, patience); end != TcpEnd::done) return end;
    const ssize_t count = ::send(descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count < 0 && is_again(errno)) continue;
    if (count < 0) return TcpEnd::closed;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return TcpEnd::done;
}

TcpSocket TcpSocket::accept(const Patience& patience) {
  while (await(descriptor(), POLLIN, patience) == TcpEnd::done) {
    TcpSocket socket = prepared(::accept4(descriptor(), nullptr, nullptr, SOCK_CLOEXEC));
    if (socket.is_open()) return socket;
    // Without file descriptors the connection waits, so poll() would return immediately.
    if (TcpClock::now() >= patience.end) break;
    if (!is_again(errno)) std::this_thread::sleep_for(kSlice);
  }
  return {};
}

int TcpSocket::port() const {
  sockaddr_in name{};
  socklen_t size = sizeof(name);
  if (!is_open() || ::getsockname(descriptor(), reinterpret_cast<sockaddr*>(&name), &size) != 0)
    return 0;
  return ntohs(name.sin_port);
}

std::string with_length(const std::string& bytes) {
  std::string message;
  for (int i = 0; i < 4; ++i)
    message += static_cast<char>(static_cast<std::uint8_t>(bytes.size() >> (8 * i)));
  return message + bytes;
}

std::uint32_t length_of(std::span<const std::byte, 4> bytes) {
  std::uint32_t length = 0;
  for (std::size_t i = 0; i < 4; ++i) length |= std::to_integer<std::uint32_t>(bytes[i]) << (8 * i);
  return length;
}

TcpSocket listen_on_loopback(int port, const std::string& who) {
  TcpSocket socket = prepared(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const int on = 1;
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(static_cast<std::uint16_t>(port));
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int descriptor = socket.descriptor();
  if (!socket.is_open() ||
      ::setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on)) != 0 ||
      ::bind(descriptor, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) != 0 ||
      ::listen(descriptor, kBacklog) != 0)
    fail(ErrorKind::device, "{} cannot be used: {}", who, std::strerror(errno));
  return socket;
}

TcpAddress resolve(const std::string& text, const std::string& who) {
  const std::size_t colon = text.rfind(':');
  std::string host = colon == text.npos ? std::string() : text.substr(0, colon);
  const std::string port = colon == text.npos ? std::string() : text.substr(colon + 1);
  const bool in_brackets = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (in_brackets) host = host.substr(1, host.size() - 2);
  int number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  const bool sound = error == std::errc() && end == port.data() + port.size() && number >= 1 &&
                     number <= 65535 && (in_brackets || host.find(':') == host.npos);
  if (host.empty() || !sound)
    fail(ErrorKind::usage, "{} {}: not a host and a port such as localhost:6009", who, text);
  addrinfo wish{};
  wish.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int problem = ::getaddrinfo(host.c_str(), port.c_str(), &wish, &found);
  if (problem != 0) fail(ErrorKind::usage, "{} {}: {}", who, text, ::gai_strerror(problem));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> list(found, ::freeaddrinfo);
  // The trainers listen at 127.0.0.1, which "localhost" may name after ::1.
  const addrinfo* chosen = found;
  while (chosen->ai_family != AF_INET && chosen->ai_next != nullptr) chosen = chosen->ai_next;
  if (chosen->ai_family != AF_INET) chosen = found;
  const auto* bytes = reinterpret_cast<const std::byte*>(chosen->ai_addr);
  return {text, {bytes, bytes + chosen->ai_addrlen}};
}

TcpSocket connect(const TcpAddress& address, const Patience& patience, int& problem) {
  sockaddr_storage name{};
  std::memcpy(&name, address.socket_name.data(),
              std::min(sizeof(name), address.socket_name.size()));
  TcpSocket socket = prepared(::socket(name.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0));
  problem = 0;
  if (!socket.is_open()) {
    problem = errno;
    return {};
  }
  if (::connect(socket.descriptor(), reinterpret_cast<const sockaddr*>(&name),
                static_cast<socklen_t>(address.socket_name.size())) == 0)
    return socket;
  problem = errno == EINPROGRESS ? 0 : errno;
  if (problem != 0 || await(socket.descriptor(), POLLOUT, patience) != TcpEnd::done) return {};
  socklen_t size = sizeof(problem);
  ::getsockopt(socket.descriptor(), SOL_SOCKET, SO_ERROR, &problem, &size);
  return problem == 0 ? std::move(socket) : TcpSocket();
}

}  // namespace qs
