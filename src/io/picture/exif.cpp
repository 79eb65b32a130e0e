// SPDX-License-Identifier: MIT
//
// The orientation in EXIF data: the tag 0x0112 of the first directory of a TIFF block, which a JPEG
// has in its segment APP1 and a PNG in its chunk eXIf. Numbers of the block are little or big
// endian, as its first two letters say.
#include <algorithm>
#include <bit>

#include "io/bytes/byte_cursor.h"
#include "io/bytes/mapped_file.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

constexpr int kUpright = 1;

std::uint32_t number_at(ByteSpan bytes, std::uint64_t at, std::size_t size, bool big_endian) {
  std::uint32_t number = 0;
  if (at > bytes.size() || bytes.size() - at < size) return 0;
  for (std::size_t i = 0; i < size; ++i)
    number =
        number << 8 | std::to_integer<std::uint32_t>(bytes[at + (big_endian ? i : size - 1 - i)]);
  return number;
}

int orientation_of_tiff(ByteSpan tiff) {
  if (tiff.size() < 8) return kUpright;
  const bool big_endian = text_of(tiff).starts_with("MM");
  const auto number = [&](std::uint64_t at, std::size_t size) {
    return number_at(tiff, at, size, big_endian);
  };
  constexpr std::uint64_t kEntryBytes = 12;
  const std::uint64_t directory = number(4, 4);
  const std::uint32_t entries = number(directory, 2);
  for (std::uint64_t i = 0; i < entries; ++i) {
    const std::uint64_t entry = directory + 2 + i * kEntryBytes;
    if (entry >= tiff.size()) break;
    if (number(entry, 2) != 0x0112) continue;
    const std::uint32_t value = number(entry + 8, 2);
    return value >= 1 && value <= 8 ? static_cast<int>(value) : kUpright;
  }
  return kUpright;
}

// The block of a JPEG. Every segment is 0xff, its kind, and its size with these two bytes.
ByteSpan tiff_of_jpeg(ByteSpan jpeg) {
  constexpr std::string_view kExif("Exif\0\0", 6);
  constexpr std::uint32_t kApp1 = 0xffe1, kFirstSegment = 0xffc0;
  for (std::uint64_t at = 2; at + 4 <= jpeg.size();) {
    const std::uint32_t kind = number_at(jpeg, at, 2, true);
    const std::uint32_t size = number_at(jpeg, at + 2, 2, true);
    if (kind < kFirstSegment || size < 2) break;
    const ByteSpan segment =
        jpeg.subspan(at + 4, std::min<std::uint64_t>(size - 2, jpeg.size() - at - 4));
    if (kind == kApp1 && text_of(segment).starts_with(kExif)) return segment.subspan(kExif.size());
    at += 2 + std::uint64_t{size};
  }
  return {};
}

// The block of a PNG. Every chunk is the size of its data, its name, the data, and a check sum.
ByteSpan tiff_of_png(ByteSpan png) {
  constexpr std::uint64_t kFirst = 8, kAround = 12;
  for (std::uint64_t at = kFirst; at + kAround <= png.size();) {
    const std::uint64_t size = number_at(png, at, 4, true);
    const ByteSpan data = png.subspan(at + 8, std::min(size, png.size() - at - 8));
    if (text_of(png.subspan(at + 4, 4)) == "eXIf") return data;
    at += kAround + size;
  }
  return {};
}

}  // namespace

int exif_orientation(ByteSpan picture) {
  if (text_of(picture).starts_with("\xff\xd8")) return orientation_of_tiff(tiff_of_jpeg(picture));
  if (text_of(picture).starts_with("\x89PNG")) return orientation_of_tiff(tiff_of_png(picture));
  return kUpright;
}

int exif_orientation(const std::filesystem::path& path) try {
  const MappedFile file(path);
  return exif_orientation(file.content());
} catch (const Error&) {
  return kUpright;  // reading the picture names the defect
}

}  // namespace qs
