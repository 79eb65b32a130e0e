// SPDX-License-Identifier: MIT
//
// The process that runs a plugin: this program with the command `plugin-host`. If a request is not
// answered in time, or the process ends, an Error is thrown and the process is killed.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

#include "app/plugin/protocol.h"
#include "base/child_process.h"

namespace qs {

class PluginProcess {
 public:
  /// Starts the process, which ends with the calling thread; the library is loaded by the first
  /// request. `scene` and `image` are descriptors that it inherits. Throws Error(device) if no
  /// process can be started.
  PluginProcess(const std::filesystem::path& library, int scene, int image);

  /// True if the last request was not answered in time.
  bool timed_out() const { return timed_out_; }

  /// Waits for the reply. Throws Error(device) with a clause that begins with a verb and describes
  /// the failure of the process, and Cancelled.
  PluginReply request(const PluginRequest& request, int timeout_s, const std::stop_token& stop);

 private:
  [[noreturn]] void report_end(PluginCall call);

  ChildProcess process_;
  bool timed_out_ = false;
};

}  // namespace qs
