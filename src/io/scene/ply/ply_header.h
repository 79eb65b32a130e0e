// SPDX-License-Identifier: MIT
//
// The header of a .ply file: its elements in file order, and the names and types of their
// properties. Nothing here is specific to splats. Counts are as the file claims; ply_rows.h checks
// them against the file's size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace qs {

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };
std::string describe(PlyFormat format);  ///< "binary little endian"
enum class PlyType : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

std::uint64_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;
  bool is_list = false;
  PlyType length_type = PlyType::u8;  ///< the type of a list's length, an integer
  std::uint64_t offset = 0;           ///< in the row, bytes; meaningless after a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  std::uint64_t row_bytes = 0;  ///< bytes of the scalar properties, when binary
  bool has_list = false;

  bool has(std::string_view property) const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;  ///< without the word "comment"
  std::uint64_t body_offset = 0;      ///< offset of the byte after end_header's line end

  /// nullptr when there is no such element.
  const PlyElement* find(std::string_view element) const;
};

/// True if the content begins with the line "ply".
bool is_ply(std::span<const std::byte> content);

/// Throws Error(input) naming the wrong line.
PlyHeader parse_ply_header(std::span<const std::byte> content, const std::filesystem::path& path);

/// The start of a .ply file as text, up to end_header: enough to recognise a dialect.
std::string_view ply_header_text(std::span<const std::byte> content);

/// The text in quotes, shortened and with unprintable characters replaced.
std::string quoted_for_message(std::string_view text);

}  // namespace qs
