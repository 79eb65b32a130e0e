// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"

namespace qs::library {

/// The rule of overwriting for the files that a call writes.
class WriteGuard {
 public:
  explicit WriteGuard(bool overwrite, const char* option = "the option overwrite")
      : guard_(overwrite, option, GuardScope::thread) {}

  /// Throws Error unless the file may be written. Call it after note_input() and before the work.
  void check(const std::filesystem::path& path) const { check_targets({path}); }

 private:
  FileGuard guard_;
};

}  // namespace qs::library
