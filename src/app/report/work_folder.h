// SPDX-License-Identifier: MIT
//
// A folder of its own among the system's temporary files, which goes when its owner does.
#pragma once

#include <filesystem>

namespace qs {

class WorkFolder {
 public:
  /// Throws Error(input) when none can be made.
  WorkFolder();
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace qs
