// SPDX-License-Identifier: MIT
//
// Appends and writes values as their little-endian bytes. byte_cursor.h reads them.
#pragma once

#include <iterator>
#include <ostream>
#include <string>

namespace qs {

/// Appends the bytes of every value.
template <class... Values>
void put_values(std::string& bytes, Values... values) {
  (bytes.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
}

/// Writes the bytes of all values of a contiguous range.
template <class Range>
void write_values(std::ostream& stream, const Range& values) {
  stream.write(reinterpret_cast<const char*>(std::data(values)),
               static_cast<std::streamsize>(std::size(values) * sizeof *std::data(values)));
}

}  // namespace qs
