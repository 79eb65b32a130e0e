// SPDX-License-Identifier: MIT
//
// The state that all connections of the web server share, on the thread of the network. Only
// live.cpp, request.cpp and server.cpp include this file, and with it Boost.
#pragma once

#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>  // Asio 1.74 uses std::exchange without it
#include <vector>

#include <boost/asio/io_context.hpp>

#include "app/serve/connections.h"
#include "app/serve/requests.h"
#include "app/serve/server.h"
#include "app/serve/sharing.h"
#include "app/serve/tls_context.h"

namespace qs {

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
  boost::asio::io_context io;

  std::string_view scheme() const { return tls ? "https" : "http"; }
};

using Place = std::unique_ptr<Connections::Place>;

/// Runs the work of a handler. An exception ends its owner, and not the server.
template <class Owner, class Work>
void guarded(Owner& owner, Work&& work) {
  try {
    work();
  } catch (const std::exception&) {
    owner.give_up();
  }
}

inline double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace qs
