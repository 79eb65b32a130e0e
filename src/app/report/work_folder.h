// SPDX-License-Identifier: MIT
//
// A new folder among the system's temporary files. The destructor deletes it.
#pragma once

#include <filesystem>

namespace qs {

class WorkFolder {
 public:
  /// Throws Error(input) if the folder cannot be created.
  WorkFolder();
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace qs
