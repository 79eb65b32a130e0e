// SPDX-License-Identifier: MIT
//
// A .rad file with a tree, of which pages (chunks) are read one at a time. Opening it reads the
// description and the first page.
#pragma once

#include <filesystem>
#include <optional>

#include <sys/stat.h>

#include "base/descriptor.h"
#include "io/scene/rad/rad_file.h"
#include "raster/pages/cut.h"

namespace qs {

/// True if the file begins as a .rad file with all chunks does.
bool is_rad_file(const std::filesystem::path& path);

class RadPages {
 public:
  /// Throws Error(input) if the file is damaged.
  explicit RadPages(std::filesystem::path path);

  const RadHeader& header() const { return header_; }
  int sh_degree() const { return sh_degree_; }
  std::uint64_t file_bytes() const { return static_cast<std::uint64_t>(opened_.st_size); }

  /// All nodes of page `i`. Several threads may call it. Throws Error(input) if the page is
  /// damaged.
  LodPage read(std::size_t i) const;

  /// False if the path leads to another file now, or the file has another size or time.
  bool is_unchanged() const;

 private:
  Array<std::byte> bytes(std::uint64_t offset, std::uint64_t count) const;
  RadChunk chunk(std::size_t i, Array<std::byte>& content) const;

  std::filesystem::path path_;
  Descriptor file_;
  struct stat opened_ = {};
  RadHeader header_;
  std::uint64_t body_ = 0;  // offset of the chunks
  std::optional<RadCodes> codes_;
  int sh_degree_ = 0;
};

}  // namespace qs
