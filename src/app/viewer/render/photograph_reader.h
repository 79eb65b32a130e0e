// SPDX-License-Identifier: MIT
//
// Reads photographs on a separate thread, one at a time. The window never waits for it: if another
// photograph is wanted before the thread has begun to read one, that one is not read at all.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "app/viewer/render/action_queue.h"

namespace qs {

class PhotographReader {
 public:
  /// Reads and reports; runs on the reader's thread.
  using Work = std::function<void(ActionQueue& reports)>;

  /// `wake` is called on the reader's thread after every report.
  explicit PhotographReader(std::function<void()> wake);

  void read(Work work);

  void take_reports(Actions& actions) { reports_.take(actions); }

  /// True while something is being read or a report waits to be taken.
  bool busy() { return reading_ || !reports_.empty(); }

 private:
  void serve(const std::stop_token& stop);

  ActionQueue reports_;
  std::atomic<bool> reading_ = false;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  Work wanted_;  // empty: nothing waits
  std::jthread thread_;
};

/// Reads the photograph of a camera as it is. An error is shown to the user.
PhotographReader::Work read_camera_photograph(const std::filesystem::path& path);

}  // namespace qs
