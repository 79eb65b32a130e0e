// SPDX-License-Identifier: MIT
//
// A file's content as memory, read-only and without a copy. The content must not shrink while it is
// mapped: another program that truncates the file in that moment ends this one (SIGBUS), which is
// the price of not copying a gigabyte.
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
