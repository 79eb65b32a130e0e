// SPDX-License-Identifier: MIT
//
// Files that a scene file refers to: beside it in its folder, or inside one archive. Names come
// from the untrusted scene file, so they are checked: none may leave the folder or be a URL, and no
// file larger than the caller expects is read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "io/bytes/byte_text.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

class FileSource {
 public:
  virtual ~FileSource() = default;

  /// The content of the file `name`, relative to the scene file. Throws Error(input) when the name
  /// is unsafe, the file is missing or damaged, or has more than `max_bytes`.
  virtual Array<std::byte> read(const std::string& name, std::uint64_t max_bytes) = 0;

  /// True if there is a file `name`.
  virtual bool has(const std::string& name) const = 0;

  /// Bytes that an existing file takes: in an archive as it is compressed there, without headers.
  virtual std::uint64_t stored_bytes(const std::string& name) const = 0;
};

/// Files in the folder of `scene_file` and below.
std::unique_ptr<FileSource> files_beside(const std::filesystem::path& scene_file);

/// Entries of a zip archive, relative to the file `root`, which is in the top folder or else in
/// exactly one folder. `content` must outlive the result.
std::unique_ptr<FileSource> files_in_zip(ByteSpan content, const std::filesystem::path& path,
                                         std::string_view root);

bool is_zip(ByteSpan content);

/// The name of the only .ply in a zip archive without SOG's meta.json; "" if it has several. Unset:
/// none, or no sound zip archive.
std::optional<std::string> ply_in_zip(ByteSpan content);

/// The name of the first file in a zip archive, as its own header states it; empty if it has none.
std::string_view first_name_in_zip(ByteSpan content);

/// True for zip archives of NumPy (.npz) and PyTorch (.pth).
bool is_npz(ByteSpan content);
bool is_torch_archive(ByteSpan content);

/// True for a zip archive of OpenUSD (.usdz), whose first file is the stage.
bool is_usdz(ByteSpan content);

/// The normalised `name`, so that different spellings are recognised as one file. Throws
/// Error(input) "source: unsafe file name ..." unless it is a plain relative path.
std::string checked_file_name(std::string_view name, std::string_view source);

}  // namespace qs
