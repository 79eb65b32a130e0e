// SPDX-License-Identifier: MIT
//
// Files that a scene file names: beside it in its folder, or inside one archive. Names come from
// the scene file, so they are checked: none leads out of the folder, none is a URL, and nothing is
// read that is larger than the caller expects.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

class FileSource {
 public:
  virtual ~FileSource() = default;

  /// The content of the file `name`, relative to the scene file. Throws Error(input) when the name
  /// is unsafe, the file is missing or damaged, or has more than `max_bytes`.
  virtual Array<std::byte> read(const std::string& name, std::uint64_t max_bytes) = 0;

  /// Whether its files lie outside the scene file, so that their bytes add to the scene's.
  virtual bool is_folder() const = 0;
};

/// Files in the folder of `scene_file` and below.
std::unique_ptr<FileSource> files_beside(const std::filesystem::path& scene_file);

/// Entries of a zip archive, relative to the one called `root` (in the top folder, or else in the
/// only folder that has one). `content` must outlive the result.
std::unique_ptr<FileSource> files_in_zip(std::span<const std::byte> content,
                                         const std::filesystem::path& path, std::string_view root);

bool is_zip(std::span<const std::byte> content);

/// `name` in its shortest form, so that equal names are one file. Throws Error(input) "source:
/// unsafe file name ..." unless it is a plain relative path.
std::string checked_file_name(std::string_view name, std::string_view source);

}  // namespace qs
