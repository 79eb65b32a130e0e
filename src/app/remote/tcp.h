// SPDX-License-Identifier: MIT
//
// TCP connections that whole messages are read from and written to. Every wait has an end and can
// be stopped, so no thread hangs on a silent peer.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "base/descriptor.h"

namespace qs {

/// The end of a wait. A stop is noticed within 50 ms.
struct Patience {
  std::chrono::steady_clock::time_point end;
  std::stop_token stop = {};
};

Patience patience(std::chrono::milliseconds time, std::stop_token stop = {});

/// The end of an exchange of bytes. `closed`: by the peer or by an error.
enum class TcpEnd { done, closed, late, stopped };

/// A connection or a listening socket. Moved, never copied; closed at its end.
class TcpSocket {
 public:
  TcpSocket() = default;
  explicit TcpSocket(int descriptor) : descriptor_(descriptor) {}

  bool is_open() const { return static_cast<bool>(descriptor_); }
  int descriptor() const { return descriptor_.get(); }
  void close() { descriptor_.reset(); }

  /// Fills `bytes`.
  TcpEnd read(std::span<std::byte> bytes, const Patience& patience);
  /// `done` as soon as there are bytes to read.
  TcpEnd await_bytes(const Patience& patience);
  /// Gives the kernel all bytes at once if it has room for them.
  TcpEnd write(std::span<const std::byte> bytes, const Patience& patience);

  /// Of a listening socket; not open at the end of the patience.
  TcpSocket accept(const Patience& patience);
  /// That it is bound to; 0 if it is not open.
  int port() const;

 private:
  Descriptor descriptor_;
};

/// A little-endian length in front of a message.
std::string with_length(const std::string& bytes);
std::uint32_t length_of(std::span<const std::byte, 4> bytes);

/// Listens at 127.0.0.1; port 0: any free one. Throws Error(device): "`who` cannot be used: ...".
TcpSocket listen_on_loopback(int port, const std::string& who);

/// The address of a peer.
struct TcpAddress {
  std::string text;                    ///< "gpu7:6009", for messages
  std::vector<std::byte> socket_name;  ///< sockaddr
};

/// `text`: HOST:PORT or [IPv6]:PORT. Asks the system for the host, which may take seconds. Throws
/// Error(usage): "`who` TEXT: ...".
TcpAddress resolve(const std::string& text, const std::string& who);

/// Not open if nothing listens there, with errno in `problem`, or at the end of the patience, with
/// 0.
TcpSocket connect(const TcpAddress& address, const Patience& patience, int& problem);

}  // namespace qs
