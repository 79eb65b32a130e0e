// SPDX-License-Identifier: MIT
//
// Maps a file into memory, read-only. The file must not shrink while it is mapped: if another
// program truncates it, this program is killed (SIGBUS). The reason for mapping is that gigabytes
// need not be copied.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace qs {

class MappedFile {
 public:
  /// Throws Error(input) when `path` is missing, unreadable or not a regular file.
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const std::byte> content() const { return content_; }

 private:
  std::span<const std::byte> content_;
};

}  // namespace qs
