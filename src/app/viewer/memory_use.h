// SPDX-License-Identifier: MIT
//
// Memory in use, for the performance panel.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>

namespace qs {

/// Resident bytes of this process; 0 if the system does not report them.
std::uint64_t process_bytes();

/// Bytes in use on a GPU by all programs; 0 if there is no such GPU. Asks this GPU alone.
std::uint64_t gpu_bytes(int device);

/// Measures bytes on a thread of its own, because the driver of a GPU may take long to answer.
class MemoryWatch {
 public:
  /// `measure` is called on the thread, after ask() and then not before `pause` has passed.
  explicit MemoryWatch(std::function<std::uint64_t()> measure,
                       std::chrono::milliseconds pause = std::chrono::seconds(1));

  /// Requests a measurement. Does not wait for it.
  void ask();

  /// The newest measurement; 0 before the first.
  std::uint64_t bytes() const { return bytes_; }

 private:
  void loop(const std::stop_token& stop);

  std::function<std::uint64_t()> measure_;
  std::chrono::milliseconds pause_;
  std::atomic<std::uint64_t> bytes_ = 0;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  bool asked_ = false;
  std::jthread thread_;  // last, because it uses the others
};

}  // namespace qs
