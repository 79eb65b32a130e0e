// SPDX-License-Identifier: MIT
//
// The desktop's own dialog for opening a file, which xdg-desktop-portal shows in a separate window.
// A thread communicates with the portal over D-Bus, so that the viewer never waits. Without a
// session bus, a portal or support in this build, the dialog is not available.
#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "app/viewer/render/action_queue.h"

namespace qs {

class DesktopDialog {
 public:
  /// Begins to look for a portal. `wake` is called on the dialog's thread after every report.
  explicit DesktopDialog(std::function<void()> wake);
  ~DesktopDialog();  ///< also closes the dialog

  /// True once a portal was found, until it fails.
  bool is_available() const { return available_; }

  /// Shows the dialog in `folder` unless it is open. A chosen file is reported as
  /// action::file_chosen, a failure of the portal by opening the viewer's own dialog.
  void show(const std::filesystem::path& folder);

  void take_reports(Actions& actions) { reports_.take(actions); }

 private:
  void serve(const std::stop_token& stop);

  ActionQueue reports_;
  std::atomic<bool> available_ = false;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<std::filesystem::path> wanted_;  // folder of the dialog that is or will be open
  std::jthread thread_;
};

}  // namespace qs
