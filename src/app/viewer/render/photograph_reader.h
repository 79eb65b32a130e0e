// SPDX-License-Identifier: MIT
//
// Reads one photograph at a time, on a separate thread.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <thread>

#include "app/viewer/render/action_queue.h"

namespace qs {

class PhotographReader {
 public:
  /// `wake` is called on the reader's thread after every report.
  explicit PhotographReader(std::function<void()> wake) : reports_(std::move(wake)) {}

  void read(const std::filesystem::path& path);

  void take_reports(Actions& actions) { reports_.take(actions); }

  /// True while something is being read or a report waits to be taken.
  bool busy() { return reading_ > 0 || !reports_.empty(); }

 private:
  ActionQueue reports_;
  std::atomic<int> reading_ = 0;  // photographs
  std::jthread thread_;
};

}  // namespace qs
