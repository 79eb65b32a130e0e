// SPDX-License-Identifier: MIT
#include "base/quit_signals.h"

#include <atomic>
#include <cerrno>

#include <unistd.h>

namespace qs {
namespace {

std::atomic<bool> signal_arrived = false;
std::atomic<int> signal_descriptor = -1;

void note_signal(int) {
  const int kept = errno;
  signal_arrived = true;
  const int descriptor = signal_descriptor;
  [[maybe_unused]] const ssize_t written = descriptor < 0 ? 0 : write(descriptor, "!", 1);
  errno = kept;
}

static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "a signal handler sets it");

}  // namespace

QuitSignals::QuitSignals() {
  signal_arrived = false;
  descriptor_ = signal_descriptor.exchange(-1);
  struct sigaction note {};
  note.sa_handler = note_signal;
  sigemptyset(&note.sa_mask);
  note.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGTERM, &note, &terminate_);
  sigaction(SIGINT, &note, &interrupt_);
}

QuitSignals::~QuitSignals() {
  sigaction(SIGTERM, &terminate_, nullptr);
  sigaction(SIGINT, &interrupt_, nullptr);
  signal_descriptor = descriptor_;
}

void QuitSignals::write_to(int descriptor) { signal_descriptor = descriptor; }

bool QuitSignals::arrived() { return signal_arrived; }

}  // namespace qs
