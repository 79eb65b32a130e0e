// SPDX-License-Identifier: MIT
//
// The directory of a zip archive, with 64-bit sizes where the archive has them. Everything that
// describes a file twice must agree, and no two files may share bytes, so that a small archive
// cannot unpack to more than its parts. Source: PKWARE's APPNOTE.TXT 6.3.10, sections 4.3 to 4.5.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "io/bytes/byte_text.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// A file in an archive.
struct ZippedFile {
  std::string name;            ///< as its bytes are in the archive
  ByteSpan stored;             ///< in the archive
  std::uint64_t bytes = 0;     ///< unpacked, as the archive announces
  std::uint32_t checksum = 0;  ///< CRC-32 of the unpacked bytes
  std::uint16_t method = 0;    ///< 0 (stored) and 8 (deflate) can be unpacked
  bool encrypted = false;
};

/// The files of the archive, in the order of its directory. `path` names it in messages. Throws
/// Error(input) "PATH: not a sound zip archive (REASON)".
std::vector<ZippedFile> zip_directory(ByteSpan archive, const std::string& path);

/// The unpacked bytes. Allocates file.bytes and one more. Throws Error(input) if the file is
/// damaged, encrypted, or compressed by another method.
Array<std::byte> unzipped(const ZippedFile& file, const std::string& path);

/// A file for a zip archive.
struct ZipEntry {
  std::string name;
  std::string content;
};

enum class ZipForm {
  stored,
  deflated,  ///< compressed
  aligned    ///< stored, and the content of each file begins at a multiple of 64 bytes, as in .usdz
};

/// Writes a zip archive with these files in their order, as replace_file(). Equal entries give
/// equal archives, because all have the time 1980-01-01. Throws Error(input).
void write_zip(const std::filesystem::path& path, const std::vector<ZipEntry>& entries,
               ZipForm form);

}  // namespace qs
