// SPDX-License-Identifier: MIT
#include "io/scene/spz/spz_container.h"

#include <algorithm>
#include <utility>

#include <zstd.h>

#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/inflate.h"
#include "io/cloud/cloud_memory.h"

namespace qs {
namespace {

constexpr std::size_t kLegacyHeaderBytes = 16;
// Known records have 4 to 12 bytes.
constexpr std::size_t kMaxExtensionBytes = 1 << 16;

// The fields from magic to flags are the same in every version.
SpzHeader read_header(ByteCursor& cursor, const std::string& path) {
  SpzHeader header;
  if (cursor.read<std::uint32_t>("the header") != kSpzMagic)
    fail("{}: not an .spz file: it does not begin with 'NGSP'", path);
  header.version = cursor.read<std::uint32_t>("the header");
  header.count = cursor.read<std::uint32_t>("the header");
  header.sh_degree = cursor.read<std::uint8_t>("the header");
  header.fractional_bits = cursor.read<std::uint8_t>("the header");
  header.flags = cursor.read<std::uint8_t>("the header");
  return header;
}

void check(const SpzHeader& header, const std::string& path) {
  if (header.count == 0) fail("{}: holds no Gaussians", path);
  if (header.sh_degree > 4) fail("{}: SH degree {} does not exist", path, header.sh_degree);
  if (header.version > 1 && header.fractional_bits > 24)
    fail("{}: {} fractional bits in 24-bit positions", path, header.fractional_bits);
  if ((header.flags & SpzHeader::kLodTree) != 0 && header.version > 3)
    fail("{}: a tree of levels of detail in version {}; they exist in 1 to 3", path,
         header.version);
}

// Sizes `content.bytes` for the header and cuts it into blocks.
void make_blocks(SpzContent& content, std::uint64_t file_bytes, const std::string& path) {
  const SpzHeader& header = content.header;
  const auto row_bytes = spz_row_bytes(header);
  std::uint64_t total = 0;
  for (const std::uint64_t bytes : row_bytes) total += bytes * header.count;  // < 2^40
  if (!fits(total, 1, file_bytes * kMaxInflation))
    fail("{}: cut off: {} Gaussians are announced, more than {} bytes can hold", path, header.count,
         file_bytes);
  content.bytes.resize(total);
  prefer_huge_pages(content.bytes.data(), total);
  ByteSpan rest = content.bytes;
  for (std::size_t i = 0; i < kSpzBlocks; ++i) {
    content.blocks[i] = rest.first(row_bytes[i] * header.count);
    rest = rest.subspan(content.blocks[i].size());
  }
}

// Fills the bytes of `out` from `filled` up to `goal`. Inflates in pieces, so that it can be
// cancelled. Returns the number of bytes in `out`.
std::size_t inflate_into(std::span<std::byte> out, std::size_t filled, std::size_t goal,
                         Inflater& inflater, const Progress& progress, float end) {
  constexpr std::size_t kPiece = 1 << 20;  // a few milliseconds
  std::size_t got = 1;
  while (filled < goal && got > 0) {
    progress.update(end * static_cast<float>(filled) / static_cast<float>(out.size()));
    got = inflater.read(out.subspan(filled, std::min(kPiece, goal - filled)));
    filled += got;
  }
  return filled;
}

SpzContent unpack_gzip(ByteSpan file, const std::string& path, const Progress& progress, float end,
                       const UseSpz& base_is_there) {
  SpzContent content;
  Inflater inflater(file, path);
  std::array<std::byte, kLegacyHeaderBytes> head;
  const ByteSpan head_bytes(head.data(), inflater.read(head));
  ByteCursor cursor(head_bytes, path);
  content.header = read_header(cursor, path);
  cursor.read<std::uint8_t>("the header");  // reserved
  const std::uint32_t version = content.header.version;
  if (version < 1 || version > 3) fail("{}: .spz version {} in gzip, 1 to 3 exist", path, version);
  check(content.header, path);
  make_blocks(content, file.size(), path);
  std::size_t base_bytes = 0;
  for (std::size_t i = 0; i < kSpzSh; ++i) base_bytes += content.blocks[i].size();
  std::size_t filled = inflate_into(content.bytes, 0, base_bytes, inflater, progress, end);
  if (filled == base_bytes) base_is_there(content);
  filled = inflate_into(content.bytes, filled, content.bytes.size(), inflater, progress, end);
  if (filled < content.bytes.size())
    fail("{}: cut off: too few bytes for its {} Gaussians", path, content.header.count);
  // Reading one byte more than allowed detects excess data, and reaching the end verifies the
  // checksum.
  const bool extended = (content.header.flags & SpzHeader::kExtensions) != 0;
  const std::size_t allowed = extended ? kMaxExtensionBytes : 0;
  content.extensions.resize(allowed + 1);
  content.extensions.resize(inflater.read(content.extensions));
  if (content.extensions.size() > allowed)
    fail("{}: holds more data than its {} Gaussians need", path, content.header.count);
  if (inflater.left() > 0)
    content.warnings.push_back(
        fmt::format("{} bytes after the gzip data were ignored.", inflater.left()));
  return content;
}

struct Stream {
  ByteSpan compressed;
  std::span<std::byte> out;
};

void unpack_zstd(const Stream& stream, std::size_t number, const std::string& path) {
  const std::size_t written = ZSTD_decompress(stream.out.data(), stream.out.size(),
                                              stream.compressed.data(), stream.compressed.size());
  if (ZSTD_isError(written) != 0)
    fail("{}: stream {} is damaged ({})", path, number, ZSTD_getErrorName(written));
  if (written != stream.out.size())
    fail("{}: stream {} has {} bytes, {} are needed", path, number, written, stream.out.size());
}

SpzContent unpack_plain(ByteSpan file, const std::string& path, ThreadPool& pool) {
  SpzContent content;
  ByteCursor cursor(file, path);
  content.header = read_header(cursor, path);
  const SpzHeader& header = content.header;
  if (header.version != 4)
    fail("{}: .spz version {} without gzip, only 4 exists", path, header.version);
  check(header, path);
  // Extensions lie between the header and the table of streams.
  const auto stream_count = cursor.read<std::uint8_t>("the header");
  const auto table_offset = cursor.read<std::uint32_t>("the header");
  cursor.take(kSpzHeaderBytes - cursor.offset(), "the header");  // reserved
  if (table_offset < kSpzHeaderBytes) fail("{}: the table of streams lies in the header", path);
  const auto between = cursor.take(table_offset - kSpzHeaderBytes, "the table of streams");
  if ((header.flags & SpzHeader::kExtensions) != 0) {
    const std::size_t kept = std::min(between.size(), kMaxExtensionBytes);
    content.extensions.assign(between.begin(), between.begin() + static_cast<std::ptrdiff_t>(kept));
  }

  // Read the table of streams.
  if (stream_count != (header.sh_degree == 0 ? 5 : 6))
    fail("{}: {} streams for SH degree {}", path, stream_count, header.sh_degree);
  std::array<std::uint64_t, kSpzBlocks> compressed_bytes{};
  const auto row_bytes = spz_row_bytes(header);
  for (std::size_t i = 0; i < stream_count; ++i) {
    compressed_bytes[i] = cursor.read<std::uint64_t>("the table of streams");
    const auto bytes = cursor.read<std::uint64_t>("the table of streams");
    if (bytes != row_bytes[i] * header.count)
      fail("{}: stream {} announces {} bytes for {} Gaussians, {} are needed", path, i, bytes,
           header.count, row_bytes[i] * header.count);
  }
  make_blocks(content, file.size(), path);
  // Unpack each stream into its part of the content.
  std::vector<Stream> streams;
  for (std::size_t i = 0, offset = 0; i < stream_count; ++i) {
    const std::size_t size = content.blocks[i].size();
    streams.push_back({cursor.take(compressed_bytes[i], "a stream"),
                       std::span(content.bytes).subspan(offset, size)});
    offset += size;
  }
  if (cursor.left() > 0)
    content.warnings.push_back(
        fmt::format("{} bytes after the last stream were ignored.", cursor.left()));
  pool.for_each(streams.size(), 1, [&](std::size_t i) { unpack_zstd(streams[i], i, path); });
  return content;
}

bool begins_with_magic(ByteSpan content) {
  return content.size() >= sizeof kSpzMagic && load<std::uint32_t>(content.data()) == kSpzMagic;
}

}  // namespace

std::array<std::uint64_t, kSpzBlocks> spz_row_bytes(const SpzHeader& header) {
  const std::uint64_t position = header.version == 1 ? 6 : 9;
  const std::uint64_t rotation = header.version <= 2 ? 3 : 4;
  const std::uint64_t degree = header.sh_degree;
  const std::uint64_t tree = (header.flags & SpzHeader::kLodTree) != 0 ? 1 : 0;
  return {position, 1, 3, 3, rotation, 3 * ((degree + 1) * (degree + 1) - 1), 2 * tree, 4 * tree};
}

bool is_spz(ByteSpan content) {
  if (!is_gzip(content)) return begins_with_magic(content);
  std::array<std::byte, sizeof kSpzMagic> head;
  return begins_with_magic(std::span(head).first(Inflater(content, "").try_read(head)));
}

SpzContent unpack_spz(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                      const Progress& progress, float end, const UseSpz& base_is_there) {
  SpzContent unpacked = is_gzip(content)
                            ? unpack_gzip(content, path.string(), progress, end, base_is_there)
                            : unpack_plain(content, path.string(), pool);
  progress.update(end);
  return unpacked;
}

}  // namespace qs
