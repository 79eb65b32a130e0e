// SPDX-License-Identifier: MIT
//
// The header of a .ply file: its elements in file order, and the names and types of their
// properties. Nothing here is specific to splats. Counts are as the file claims; PlyBody checks
// them against the file's size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/progress.h"
#include "io/bytes/byte_text.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };
std::string describe(PlyFormat format);  ///< "binary little endian"
enum class PlyType : std::uint8_t { i8, u8, i16, u16, i32, u32, f16, f32, f64 };

std::uint64_t size_of(PlyType type);

/// The item of this name; nullptr if there is none.
template <class Item>
const Item* find_named(const std::vector<Item>& items, std::string_view name) {
  for (const Item& item : items)
    if (item.name == name) return &item;
  return nullptr;
}

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

  bool has(std::string_view property) const { return find_named(properties, property) != nullptr; }
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;  ///< without the word "comment"
  std::uint64_t body_offset = 0;      ///< offset of the byte after end_header's line end

  /// nullptr when there is no such element.
  const PlyElement* find(std::string_view element) const { return find_named(elements, element); }
};

/// True if the content begins with the line "ply".
bool is_ply(ByteSpan content);

/// Throws Error(input) naming the wrong line.
PlyHeader parse_ply_header(ByteSpan content, const std::filesystem::path& path);

/// The start of a .ply file as text, up to end_header: enough to recognise a dialect.
std::string_view ply_header_text(ByteSpan content);

/// The text in quotes, shortened and with unprintable characters replaced.
std::string quoted_for_message(std::string_view text);

// The rows of one element of a .ply file, in any encoding, as a table with a fixed row size. Binary
// rows without lists are used in place; ascii rows and rows with lists are decoded to doubles
// first. Every count is checked against the file's size before anything is allocated or visited.

struct PlyColumn {
  std::string name;
  PlyType type = PlyType::f32;
  std::uint64_t offset = 0;       ///< in the row, bytes
  PlyType stored = PlyType::f32;  ///< as the header declares it; decoded rows have doubles
};

struct PlyRows {
  const std::byte* data = nullptr;  ///< count * row_bytes bytes, all within the file
  std::uint64_t count = 0, row_bytes = 0;
  bool swap_bytes = false;  ///< values are big-endian
  std::vector<PlyColumn> columns;
  Array<double> decoded;  ///< backing storage of `data` if the rows are not used in place

  /// nullptr if no scalar property has this name.
  const PlyColumn* find(std::string_view column) const { return find_named(columns, column); }
  /// Throws Error(input) "PATH: the vertices have no property ...".
  const PlyColumn& of_vertices(std::string_view column, const std::string& path) const;
  double value(std::uint64_t row, const PlyColumn& column) const;
};

class PlyBody {
 public:
  /// All arguments must outlive the body.
  PlyBody(ByteSpan content, const PlyHeader& header, const std::filesystem::path& path,
          const Progress& progress)
      : content_(content), header_(header), path_(path.string()), progress_(progress) {}

  /// Throws Error(input) if the element does not exist or its rows are cut off or damaged;
  /// Cancelled.
  PlyRows rows(std::string_view element);

  /// Warnings about trailing elements or bytes that were not read; usually empty.
  std::vector<std::string> leftovers();

 private:
  std::uint64_t begin_of(std::size_t element);
  [[noreturn]] void refuse(const PlyElement& element, std::string_view problem) const;

  ByteSpan content_;
  const PlyHeader& header_;
  std::string path_;
  const Progress& progress_;
  std::vector<std::uint64_t>
      begins_;  // start offsets of the elements found so far and of the next element
};

}  // namespace qs
