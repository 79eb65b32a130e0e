// SPDX-License-Identifier: MIT
//
// Opens folders in the desktop's file manager by xdg-open, without waiting for it.
#pragma once

#include <filesystem>
#include <optional>

#include "app/base/child_process.h"
#include "app/viewer/state/action.h"

namespace qs {

class FolderOpener {
 public:
  /// Starts xdg-open. A failure is reported by take_report().
  void open(const std::filesystem::path& folder);

  /// Appends a message with the folder's path if it could not be opened.
  void take_report(Actions& actions);

 private:
  std::filesystem::path folder_;
  std::optional<ChildProcess> child_;
  bool failed_ = false;
};

}  // namespace qs
