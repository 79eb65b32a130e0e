// SPDX-License-Identifier: MIT
//
// The process that runs a plugin: this program with the command `plugin-host`. If a request is not
// answered in time, or the process ends, an Error is thrown and the process is killed.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

#include <sys/types.h>

#include "app/plugin/protocol.h"
#include "app/plugin/shared_memory.h"

namespace qs {

class PluginProcess {
 public:
  /// Starts the process, which ends with the calling thread; the library is loaded by the first
  /// request. `scene` and `image` are descriptors that it inherits. Throws Error(device) if no
  /// process can be started.
  PluginProcess(const std::filesystem::path& library, int scene, int image);
  /// Ends the process.
  ~PluginProcess();
  PluginProcess(const PluginProcess&) = delete;
  PluginProcess& operator=(const PluginProcess&) = delete;

  /// False after request() threw.
  bool running() const { return process_ > 0; }

  /// True if the last request was not answered in time.
  bool timed_out() const { return timed_out_; }

  /// Waits for the reply. Throws Error(device) with a clause that begins with a verb and describes
  /// the failure of the process, and Cancelled.
  PluginReply request(const PluginRequest& request, int timeout_s, const std::stop_token& stop);

 private:
  void kill_and_wait();
  [[noreturn]] void report_end(PluginCall call);

  Descriptor socket_;
  pid_t process_ = 0;
  bool timed_out_ = false;
};

}  // namespace qs
