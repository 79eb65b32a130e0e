// SPDX-License-Identifier: MIT
//
// NPY, the arrays of NumPy: a header in Python's syntax, and the values. NPZ is a zip archive of
// such files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/bytes/byte_text.h"

namespace qs {

struct NpyHeader {
  std::string_view type;  ///< as NumPy writes it: "<f4"; empty if there is none
  bool is_c_order = false;
  std::optional<std::vector<std::int64_t>> shape;  ///< unset if it is no tuple of integers
  std::size_t size = 0;                            ///< bytes of the header
};

/// Throws Error(input) that begins with `source`.
NpyHeader parse_npy_header(std::string_view content, const std::string& source);

/// The first bytes of a file in C order, with padding: its values follow. `shape` is in Python's
/// syntax: "(2, 3)".
std::string npy_header(std::string_view type, std::string_view shape);

struct NpyArray {
  std::string_view type;
  std::vector<std::uint64_t> shape;
  ByteSpan values;  ///< fill the shape; a pickle if the type is "|O"

  std::uint64_t count() const;  ///< number of values
};

/// The array of a whole file, in C order. `content` must outlive it. Throws Error(input), one
/// sentence that begins with `source`, also if the values do not fill the shape.
NpyArray parse_npy(ByteSpan content, const std::string& source);

}  // namespace qs
