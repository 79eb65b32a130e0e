// SPDX-License-Identifier: MIT
//
// Counts the server's connections by kind and by address, so that nobody can occupy all of them.
// Without sockets; the caller gives the times. An address is forgotten when it has no connection
// and has sent no wrong token in the last minute.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/not_copied.h"

namespace qs {

struct ConnectionLimit {
  int all = 0, per_address = 0;
};

/// Limits of the requests and messages of a client. Tests use smaller limits.
struct ServeLimits {
  /// By ConnectionKind. All visitors of an SSH tunnel have one address, and a browser loads the
  /// page by six connections at once.
  ConnectionLimit requests{128, 64}, visitors{64, 32}, leaving{64, 64};
  std::size_t head_bytes = 8192;      ///< of a request
  std::size_t target_bytes = 1024;    ///< of the path in it
  std::size_t message_bytes = 65536;  ///< of a client's message, without a file
  int messages_per_second = 200;
  int wrong_tokens_per_minute = 10;             ///< from one address
  std::chrono::milliseconds head_time{5000};    ///< for a request to be complete
  std::chrono::milliseconds token_time{3000};   ///< for the first message, which has the token
  std::chrono::milliseconds pong_time{15000};   ///< for a sign of life
  std::chrono::milliseconds write_time{10000};  ///< for a message to leave
};

/// A request has not been answered, or is a WebSocket that has not shown the token. A leaving
/// connection was refused or answered, and stays until the client has read the answer. A browser
/// opens its next connection before it closes such a one.
enum class ConnectionKind { request, visitor, leaving };

class Connections : NotCopied {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit Connections(const ServeLimits& limits) : limits_(limits) {}

  /// A connection that is counted as long as this object exists.
  class Place : NotCopied {
   public:
    ~Place();

    ConnectionKind kind() const { return kind_; }
    const std::string& address() const { return address_; }
    /// False if there is no room for another connection of this kind; then nothing changes.
    bool move_to(ConnectionKind kind);

   private:
    friend class Connections;
    Place(Connections& all, std::string address, ConnectionKind kind);

    Connections& all_;
    std::string address_;
    ConnectionKind kind_;
  };

  /// The place of a new connection: `request`, or `leaving` if it has to be refused. Null if there
  /// is no room for a refusal either.
  std::unique_ptr<Place> enter(const std::string& address);

  void note_wrong_token(const std::string& address, Time now);
  bool has_too_many_wrong_tokens(const std::string& address, Time now);

  /// Forgets addresses. Called from time to time.
  void prune(Time now);
  /// The addresses that are remembered.
  std::size_t addresses() const { return addresses_.size(); }

 private:
  using Counts = std::array<int, 3>;  // index = ConnectionKind
  struct Address {
    Counts connections{};
    std::vector<Time> wrong_tokens;  // of the last minute
  };

  bool has_room(const std::string& address, ConnectionKind kind) const;
  void count(const std::string& address, ConnectionKind kind, int change);
  static void forget_old(Address& address, Time now);

  const ServeLimits& limits_;
  Counts counts_{};
  std::map<std::string, Address> addresses_;
};

}  // namespace qs
