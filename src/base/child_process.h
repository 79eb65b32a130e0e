// SPDX-License-Identifier: MIT
//
// A process that this program starts, feeds and waits for. Every other process of the program is
// started here. The child has the descriptors that its command names, and all others are closed.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <sys/types.h>

#include "base/descriptor.h"

namespace qs {

struct ChildCommand {
  /// A socket between the two processes. `type`: SOCK_STREAM or SOCK_SEQPACKET.
  struct Socket {
    int type, number_in_child;
  };
  struct Inherited {
    int number, number_in_child;
  };

  /// The program, which is searched in PATH if it has no slash, and its arguments.
  std::vector<std::string> words;
  std::filesystem::path folder = {};  ///< its working folder; empty: the current folder
  bool own_group = false;             ///< Ctrl+C in the terminal does not reach the child
  bool keeps_messages = false;        ///< its stderr is kept for messages()
  std::optional<Socket> socket = {};
  /// Further descriptors. The child's 0, 1 and 2 are /dev/null unless something else takes them.
  std::vector<Inherited> inherits = {};
};

/// The end of a process: by itself, with an exit code, or by a signal.
struct ChildEnd {
  int exit_code = 0, signal = 0;

  bool good() const { return exit_code == 0 && signal == 0; }
  /// "exit code 3" or "signal 6 (Aborted)".
  std::string text() const;
};

class ChildProcess {
 public:
  /// Throws Error(device) "PROGRAM does not start: REASON".
  explicit ChildProcess(const ChildCommand& command);
  /// Kills the process if it runs.
  ~ChildProcess();

  /// False after the end of the process was waited for.
  bool running() const { return process_ > 0; }

  /// Sends all bytes, or one message, through the socket. False if the child closed its end,
  /// usually because it ended.
  bool send(std::span<const std::byte> bytes);

  /// True if receive() would not block, after waiting `limit` at most.
  bool can_receive(std::chrono::milliseconds limit) const;

  /// Receives one message of exactly this size. False as send().
  bool receive(std::span<std::byte> message);

  /// The child reads the end of its input.
  void close_socket() { socket_.reset(); }

  ChildEnd wait();
  /// Nothing if the process still runs after `limit`.
  std::optional<ChildEnd> wait_for(std::chrono::milliseconds limit);
  /// Asks the process to end, by SIGTERM.
  void terminate();
  /// Kills the process immediately, by SIGKILL.
  void kill();

  /// The first bytes of the child's stderr, if the command keeps them.
  std::string messages(std::size_t most_bytes) const;

 private:
  Descriptor socket_, messages_;
  pid_t process_ = 0;
};

}  // namespace qs
