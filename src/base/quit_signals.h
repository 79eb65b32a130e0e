// SPDX-License-Identifier: MIT
//
// SIGTERM and SIGINT (Ctrl+C in the terminal).
#pragma once

#include <condition_variable>
#include <csignal>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "base/not_copied.h"

namespace qs {

/// Notes the signals, so that the window saves its settings and training its checkpoint before the
/// program ends. A second signal ends the program immediately.
class QuitSignals : NotCopied {
 public:
  /// From now on the signals are noted instead of ending the program. The newest object has the
  /// signals; its destructor gives them back to the previous object.
  QuitSignals();
  ~QuitSignals();

  /// True once a signal has arrived.
  static bool arrived();

  /// A signal also writes a byte to this descriptor; -1: to none.
  void write_to(int descriptor);

 private:
  struct sigaction terminate_ {
  }, interrupt_{};       // the previous handlers
  int descriptor_ = -1;  // descriptor of the previous object
};

/// The exit code of an interrupted program, as shells give it for SIGINT.
inline constexpr int kExitInterrupted = 130;

/// Ends a command within a second of a signal. While it exists, a signal is first noted
/// (QuitSignals::arrived()), so that work can end itself.
/// If the object still exists 0.7 s later, the unfinished files are deleted
/// (base/temporaries.h), sentence() is printed to stderr, and the process exits with
/// kExitInterrupted. Work that needs longer, such as saving a model, creates a QuitSignals, which
/// takes the signals over.
class EndAtSignal {
 public:
  /// Another thread calls `sentence`.
  explicit EndAtSignal(std::function<std::string()> sentence);
  ~EndAtSignal();

 private:
  void wait_for_signal();

  std::function<std::string()> sentence_;
  int pipe_[2] = {-1, -1};
  QuitSignals signals_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool over_ = false;
  std::thread thread_;
};

}  // namespace qs
