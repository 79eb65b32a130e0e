// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace qs {

/// A file for a zip archive.
struct ZipEntry {
  std::string name;
  std::string content;
};

/// Writes a zip archive with these files in their order, as replace_file(). `deflated`: compressed.
/// Equal entries give equal archives, because all have the time 1980-01-01. Throws Error(input).
void write_zip(const std::filesystem::path& path, const std::vector<ZipEntry>& entries,
               bool deflated);

}  // namespace qs
