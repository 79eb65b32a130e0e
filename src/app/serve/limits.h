// SPDX-License-Identifier: MIT
//
// Limits of the requests and messages of a client. Tests use smaller limits.
#pragma once

#include <chrono>
#include <cstddef>

namespace qs {

struct ConnectionLimit {
  int all = 0, per_address = 0;
};

struct ServeLimits {
  /// By ConnectionKind. All visitors of an SSH tunnel have one address, and a browser loads the
  /// page by six connections at once.
  ConnectionLimit requests{128, 64}, visitors{64, 32}, leaving{64, 64};
  std::size_t head_bytes = 8192;      ///< of a request
  std::size_t target_bytes = 1024;    ///< of the path in it
  std::size_t message_bytes = 65536;  ///< of a client's message
  int messages_per_second = 200;
  int wrong_tokens_per_minute = 10;             ///< from one address
  std::chrono::milliseconds head_time{5000};    ///< for a request to be complete
  std::chrono::milliseconds token_time{3000};   ///< for the first message, which has the token
  std::chrono::milliseconds pong_time{15000};   ///< for a sign of life
  std::chrono::milliseconds write_time{10000};  ///< for a message to leave
};

}  // namespace qs
