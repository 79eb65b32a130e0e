// SPDX-License-Identifier: MIT
//
// Hashes by which files and sets are recognised again.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace qs {

/// "crc32:89abcdef" of bytes.
std::string bytes_hash(std::span<const std::byte> bytes);

/// The same of a file's content. Throws Error(input).
std::string file_hash(const std::filesystem::path& path);

}  // namespace qs
