// SPDX-License-Identifier: MIT
//
// Ctrl+C (SIGINT) and SIGTERM end a command within a second.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "base/quit_signals.h"

namespace qs {

/// The exit code of an interrupted program, as shells give it for SIGINT.
inline constexpr int kExitInterrupted = 130;

/// While it exists, a signal is first noted (QuitSignals::arrived()), so that work can end itself.
/// If the object still exists 0.7 s later, the unfinished files are deleted
/// (base/temporaries.h), sentence() is printed to stderr, and the process exits with
/// kExitInterrupted. Work that needs longer, such as saving a model, creates a QuitSignals, which
/// takes the signals over.
class EndAtSignal {
 public:
  /// Another thread calls `sentence`.
  explicit EndAtSignal(std::function<std::string()> sentence);
  ~EndAtSignal();
  EndAtSignal(const EndAtSignal&) = delete;
  EndAtSignal& operator=(const EndAtSignal&) = delete;

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
