// SPDX-License-Identifier: MIT
#include "app/base/quit_signals.h"

#include <atomic>

namespace qs {
namespace {

std::atomic<bool> signal_arrived = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");

}  // namespace

QuitSignals::QuitSignals() {
  signal_arrived = false;
  struct sigaction note {};
  note.sa_handler = [](int) { signal_arrived = true; };
  sigemptyset(&note.sa_mask);
  note.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGTERM, &note, &terminate_);
  sigaction(SIGINT, &note, &interrupt_);
}

QuitSignals::~QuitSignals() {
  sigaction(SIGTERM, &terminate_, nullptr);
  sigaction(SIGINT, &interrupt_, nullptr);
}

bool QuitSignals::arrived() { return signal_arrived; }

}  // namespace qs
