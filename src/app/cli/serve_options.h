// SPDX-License-Identifier: MIT
//
// The options of the web server that `serve` and `train --serve` share.
#pragma once

#include <string>

#include "app/cli/options.h"
#include "app/serve/server.h"

namespace qs {

/// --port, --address, --name, --certificate and --key. `addresses`: samples of --address.
void declare_serve_options(Options& options, ServeOptions& serve,
                           const Options::Samples& addresses);
inline constexpr const char* kServeOptions[] = {"--port", "--address", "--name", "--certificate",
                                                "--key"};

/// Makes a token. Throws Error(usage) if one of --certificate and --key is missing.
void complete(ServeOptions& serve);

/// Prints the address of the page, and that `what` is served.
void print_address(const ServeOptions& serve, int port, const std::string& what);

}  // namespace qs
