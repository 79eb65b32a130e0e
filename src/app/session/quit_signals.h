// SPDX-License-Identifier: MIT
//
// Makes SIGTERM and SIGINT (Ctrl+C in the terminal) close the window in order, so that the settings
// are saved. A second signal ends the program at once.
#pragma once

#include <csignal>

namespace qs {

class QuitSignals {
 public:
  /// From now on the signals are noted instead of ending the program. One object at a time.
  QuitSignals();
  ~QuitSignals();
  QuitSignals(const QuitSignals&) = delete;
  QuitSignals& operator=(const QuitSignals&) = delete;

  /// True once a signal has arrived.
  static bool arrived();

 private:
  struct sigaction terminate_ {
  }, interrupt_{};  // what they did before
};

}  // namespace qs
