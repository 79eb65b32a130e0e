// SPDX-License-Identifier: MIT
//
// A connection of a client from its first byte: encryption, the head of one request, and its answer
// or the WebSocket of a visitor.
#pragma once

#include <boost/asio/ip/tcp.hpp>

#include "app/serve/hub.h"

namespace qs {

/// `place`: of kind `leaving` if the request is refused unread.
void begin_request(Hub& hub, boost::asio::ip::tcp::socket socket, Place place);

}  // namespace qs
