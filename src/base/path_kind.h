// SPDX-License-Identifier: MIT
//
// Questions about a path. An unreachable file counts as missing, and no function throws.
#pragma once

#include <filesystem>
#include <system_error>

namespace qs {

inline bool is_there(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::exists(path, error);
}
inline bool is_file(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error);
}
inline bool is_folder(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_directory(path, error);
}

}  // namespace qs
