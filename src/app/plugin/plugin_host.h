// SPDX-License-Identifier: MIT
//
// The other side of PluginProcess: loads a plugin and calls it for every request, until the socket
// is closed. A crash of the plugin ends this process and nothing else.
#pragma once

#include <string>

namespace qs {

/// Answers the requests at kPluginSocket and returns the exit code. Throws Error(usage) if there is
/// no such socket.
int run_plugin_host(const std::string& library);

}  // namespace qs
