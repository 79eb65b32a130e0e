// SPDX-License-Identifier: MIT
#include "base/quit_signals.h"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "base/fail.h"
#include "base/temporaries.h"

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

constexpr std::chrono::milliseconds kTimeToEnd{700};

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

EndAtSignal::EndAtSignal(std::function<std::string()> sentence) : sentence_(std::move(sentence)) {
  if (pipe2(pipe_, O_CLOEXEC) != 0) fail(ErrorKind::device, "the system gives no pipe");
  signals_.write_to(pipe_[1]);
  thread_ = std::thread([this] { wait_for_signal(); });
}

EndAtSignal::~EndAtSignal() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  changed_.notify_all();
  signals_.write_to(-1);
  close(pipe_[1]);
  thread_.join();
  close(pipe_[0]);
}

void EndAtSignal::wait_for_signal() {
  char signal = 0;
  while (read(pipe_[0], &signal, 1) < 0 && errno == EINTR) {
  }
  std::unique_lock lock(mutex_);
  if (changed_.wait_for(lock, kTimeToEnd, [&] { return over_; })) return;
  delete_temporaries();
  const std::string text =
      fmt::format("{}quadsplat: {}\n", isatty(STDERR_FILENO) ? "\r\033[K" : "", sentence_());
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
  _exit(kExitInterrupted);
}

}  // namespace qs
