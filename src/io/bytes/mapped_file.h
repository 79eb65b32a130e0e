// SPDX-License-Identifier: MIT
//
// The bytes of a file: mapped into memory, or copied. Mapping copies no gigabytes, but a mapped
// file must not shrink: if another program truncates it, this program is killed (SIGBUS).
// libquadsplat copies, because it must not kill its host.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

#include "io/bytes/byte_text.h"

namespace qs {

class MappedFile {
 public:
  /// Throws Error(input) when `path` is missing, unreadable, not a regular file or a pointer of Git
  /// LFS, or when another program truncates it while it is copied.
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();

  ByteSpan content() const { return content_; }

  /// `copies`: from now on this process copies the files that it opens. At first it maps them.
  static void copy_files(bool copies);

 private:
  ByteSpan content_;
  std::unique_ptr<std::byte[]> copy_;  // null: the content is mapped
};

}  // namespace qs
