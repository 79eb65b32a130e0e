// SPDX-License-Identifier: MIT
//
// Data outside of the repository: golden counts and images, large scenes, the file corpus. Tests
// that need it skip with a message if it is missing.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "support/paths.h"

namespace qs::test {

/// A path inside the shared folder, which need not exist. An environment variable can name another
/// folder, for tests that run on another machine.
inline std::filesystem::path shared_path(const std::string& relative) {
  const char* elsewhere = std::getenv("QUADSPLAT_SHARED_DIR");
  return (elsewhere != nullptr ? std::filesystem::path(elsewhere) : shared_folder()) / relative;
}

}  // namespace qs::test

/// Skips the running test if `relative` is not in the shared folder.
#define QS_NEEDS_SHARED(relative)                                \
  if (!std::filesystem::exists(qs::test::shared_path(relative))) \
  GTEST_SKIP() << "needs " << (relative) << " of the shared data folder, which is not here"
