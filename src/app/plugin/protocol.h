// SPDX-License-Identifier: MIT
//
// The messages between quadsplat and the process that runs a plugin. Both ends are the same
// program. One message per request and one per reply on a socket that keeps message borders; arrays
// and images are in shared memory.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "quadsplat/plugin.h"

namespace qs {

/// The argument that makes this program a plugin's process; the library follows.
inline constexpr const char* kPluginHostCommand = "plugin-host";

/// The process of PluginRenderer: loads a plugin and calls it for every request, until the socket
/// is closed. A crash of the plugin ends this process and nothing else. Answers the requests at
/// kPluginSocket and returns the exit code. Throws Error(usage) if there is no such socket.
int run_plugin_host(const std::string& library);

/// The descriptors of that process.
enum PluginDescriptor { kPluginSocket = 3, kPluginScene = 4, kPluginImage = 5 };

enum class PluginCall : std::uint32_t { open, render, close };

/// The pointers of `scene` and `frame` are not used.
struct PluginRequest {
  PluginCall call = PluginCall::open;
  std::int32_t wants_image = 0;  ///< render: 1 = the image is copied to shared memory, HWC or CHW
  QsScene scene = {};            ///< open
  QsView view = {};              ///< render
  std::int32_t mark_stages = 0;  ///< render
};

template <std::size_t kBytes>
using PluginText = std::array<char, kBytes>;  ///< ends with a 0

struct PluginReply {
  std::int32_t failed = 0;
  /// if failed: the failure as a predicate whose subject is the plugin
  PluginText<1024> message = {};
  // open
  std::uint32_t memory = QS_MEMORY_HOST, image_layout = QS_IMAGE_HWC;
  PluginText<33> name = {};
  PluginText<256> description = {};
  // render
  QsFrame frame = {};
  double call_ms = 0;  ///< time of the call by the host's clock
};

}  // namespace qs
