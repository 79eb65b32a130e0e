// SPDX-License-Identifier: MIT
//
// Git LFS leaves a pointer, a text of three lines, in place of a large file that was not fetched.
// Every function that opens a file refuses it by name, because the reader of the format would call
// it damaged.
#pragma once

#include <filesystem>
#include <string_view>

#include "base/fail.h"

namespace qs {

/// Throws Error(input) "PATH: a Git LFS pointer ..." if the file begins so. `start` has at least
/// the first 64 bytes of the file, or all.
inline void refuse_lfs_pointer(std::string_view start, const std::filesystem::path& path) {
  if (start.starts_with("version https://git-lfs.github.com/spec/"))
    fail("{}: a Git LFS pointer, not the file: git lfs pull", path.string());
}

}  // namespace qs
