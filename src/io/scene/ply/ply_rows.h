// SPDX-License-Identifier: MIT
//
// The rows of one element of a .ply file, in any encoding, as a table with a fixed row size. Binary
// rows without lists are used in place; ascii rows and rows with lists are decoded to doubles
// first. Every count is checked against the file's size before anything is allocated or visited.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/progress.h"
#include "io/scene/ply/ply_header.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

struct PlyColumn {
  std::string name;
  PlyType type = PlyType::f32;
  std::uint64_t offset = 0;  ///< in the row, bytes
};

struct PlyRows {
  const std::byte* data = nullptr;  ///< count * row_bytes bytes, all within the file
  std::uint64_t count = 0, row_bytes = 0;
  bool swap_bytes = false;  ///< values are big-endian
  std::vector<PlyColumn> columns;
  Array<double> decoded;  ///< backing storage of `data` if the rows are not used in place

  /// nullptr if no scalar property has this name.
  const PlyColumn* find(std::string_view column) const;
  double value(std::uint64_t row, const PlyColumn& column) const;
};

class PlyBody {
 public:
  /// All arguments must outlive the body.
  PlyBody(std::span<const std::byte> content, const PlyHeader& header,
          const std::filesystem::path& path, const Progress& progress)
      : content_(content), header_(header), path_(path.string()), progress_(progress) {}

  /// Throws Error(input) if the element does not exist or its rows are cut off or damaged;
  /// Cancelled.
  PlyRows rows(std::string_view element);

  /// Warnings about trailing elements or bytes that were not read; usually empty.
  std::vector<std::string> leftovers();

 private:
  std::uint64_t begin_of(std::size_t element);
  [[noreturn]] void refuse(const PlyElement& element, std::string_view problem) const;

  std::span<const std::byte> content_;
  const PlyHeader& header_;
  std::string path_;
  const Progress& progress_;
  std::vector<std::uint64_t>
      begins_;  // start offsets of the elements found so far and of the next element
};

}  // namespace qs
