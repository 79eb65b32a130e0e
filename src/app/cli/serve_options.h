// SPDX-License-Identifier: MIT
//
// The options of the web server that `serve` and `train --serve` share.
#pragma once

#include <string>

#include "app/cli/options.h"
#include "app/serve/server.h"

namespace qs {

/// --port, --address and --name. `addresses`: samples of --address.
void declare_serve_options(Options& options, ServeOptions& serve,
                           const Options::Samples& addresses);

/// Prints the address of the page, and that `what` is served.
void print_address(const ServeOptions& serve, int port, const std::string& what);

/// Warns if other machines reach the address of the server without encryption.
void warn_of_address(const Server& server, const ServeOptions& serve);

}  // namespace qs
