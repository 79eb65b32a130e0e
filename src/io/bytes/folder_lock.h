// SPDX-License-Identifier: MIT
//
// Lets one process at a time write into a folder. The kernel holds the lock (flock on the folder
// itself), so nothing is left when the process ends, not even after kill -9.
#pragma once

#include <filesystem>

#include "base/descriptor.h"

namespace qs {

class FolderLock {
 public:
  /// Locks an existing folder until the destructor runs. Throws Error(usage) "PATH: WHO" if another
  /// lock exists, in this process or another: `who` says who has it.
  FolderLock(const std::filesystem::path& folder, const char* who);

  /// False: the file system cannot lock folders, so nothing is locked.
  bool held() const { return static_cast<bool>(folder_); }

 private:
  Descriptor folder_;
};

}  // namespace qs
