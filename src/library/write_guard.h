// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <mutex>

#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"

namespace qs::library {

/// The rule of overwriting for the file that a call writes. Calls wait for each other, because a
/// process has one FileGuard at a time.
class WriteGuard {
 public:
  explicit WriteGuard(bool overwrite) : lock_(mutex()), guard_(overwrite, "the option overwrite") {}

  /// Throws Error unless the file may be written. Call it after note_input() and before the work.
  void check(const std::filesystem::path& path) const { check_targets({path}); }

 private:
  static std::mutex& mutex() {
    static std::mutex of_all_calls;
    return of_all_calls;
  }

  std::lock_guard<std::mutex> lock_;
  FileGuard guard_;
};

}  // namespace qs::library
