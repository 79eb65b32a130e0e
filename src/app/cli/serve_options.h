// SPDX-License-Identifier: MIT
//
// The options of the web server that `serve` and `train --serve` share.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/cli/options.h"
#include "app/serve/server.h"

namespace qs {

/// As they were given; unset ones have the defaults of ServeOptions.
struct ServeChoice {
  std::optional<int> port;
  std::optional<std::string> address, name;
  std::optional<std::filesystem::path> certificate, key;

  /// The name of an option that was given; null if none was.
  const char* given() const;
};

/// --port, --address, --name, --certificate and --key. `addresses`: samples of --address.
void declare_serve_options(Options& options, ServeChoice& choice,
                           const Options::Samples& addresses);

/// The options of the server of this command, with a new token. Throws Error(usage) if one of
/// --certificate and --key is missing.
ServeOptions serve_options(const ServeChoice& choice, const std::string& command);

/// Prints the address of the page, and that `what` is served.
void print_address(const ServeOptions& serve, int port, const std::string& what);

/// Prints what the user should know before visitors come (Server::warnings()).
void print_warnings(const Server& server);

}  // namespace qs
