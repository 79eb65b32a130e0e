// SPDX-License-Identifier: MIT
#include "io/bytes/file_hash.h"

#include <fstream>
#include <vector>

#include <zlib.h>

#include "base/fail.h"

namespace qs {
namespace {

uLong crc_with(uLong crc, const void* bytes, std::size_t count) {
  return crc32_z(crc, static_cast<const Bytef*>(bytes), count);
}

std::string crc_text(uLong crc) { return fmt::format("crc32:{:08x}", crc); }

}  // namespace

std::string bytes_hash(std::span<const std::byte> bytes) {
  return crc_text(crc_with(0, bytes.data(), bytes.size()));
}

std::string file_hash(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  uLong crc = 0;
  std::vector<char> block(std::size_t{1} << 20);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())), file.gcount() > 0)
    crc = crc_with(crc, block.data(), static_cast<std::size_t>(file.gcount()));
  if (!file.eof()) fail("{}: cannot be read", path.string());
  return crc_text(crc);
}

}  // namespace qs
