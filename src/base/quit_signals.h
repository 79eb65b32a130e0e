// SPDX-License-Identifier: MIT
//
// Notes SIGTERM and SIGINT (Ctrl+C in the terminal), so that the window saves its settings and
// training its checkpoint before the program ends. A second signal ends the program immediately.
#pragma once

#include <csignal>

namespace qs {

class QuitSignals {
 public:
  /// From now on the signals are noted instead of ending the program. The newest object has the
  /// signals; its destructor gives them back to the previous object.
  QuitSignals();
  ~QuitSignals();
  QuitSignals(const QuitSignals&) = delete;
  QuitSignals& operator=(const QuitSignals&) = delete;

  /// True once a signal has arrived.
  static bool arrived();

  /// A signal also writes a byte to this descriptor; -1: to none.
  void write_to(int descriptor);

 private:
  struct sigaction terminate_ {
  }, interrupt_{};       // the previous handlers
  int descriptor_ = -1;  // descriptor of the previous object
};

}  // namespace qs
