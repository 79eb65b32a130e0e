// SPDX-License-Identifier: MIT
//
// Reads numbers from untrusted bytes. Every read is checked against the bytes left, in 64 bits;
// loads work at any alignment. Files are little-endian unless documented otherwise, as is every
// machine this program runs on.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <iterator>
#include <ostream>
#include <span>
#include <string>
#include <utility>

#include "base/fail.h"
#include "io/bytes/byte_text.h"

namespace qs {

static_assert(std::endian::native == std::endian::little);

/// The value whose little-endian bytes start at `at`, at any alignment.
template <class T>
T load(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

/// True if `count` items of `item_bytes` fit into `available` bytes; never overflows.
constexpr bool fits(std::uint64_t count, std::uint64_t item_bytes, std::uint64_t available) {
  return item_bytes == 0 || count <= available / item_bytes;
}

/// Reads `bytes` from the front. Messages begin with the source and name the value that was read.
class ByteCursor {
 public:
  ByteCursor(ByteSpan bytes, std::string source)
      : ByteCursor(bytes, [source = std::move(source)] { return source; }) {}

  /// `source` is called only if something is wrong, so readers of many records format no names.
  ByteCursor(ByteSpan bytes, std::function<std::string()> source)
      : bytes_(bytes), source_(std::move(source)) {}

  std::uint64_t offset() const { return offset_; }
  std::uint64_t left() const { return bytes_.size() - offset_; }

  /// The next `count` bytes. Throws Error(input) when fewer are left.
  ByteSpan take(std::uint64_t count, const char* what) {
    if (count > left())
      fail("{}: cut off: {} needs {} bytes at offset {}, {} are left", source_(), what, count,
           offset_, left());
    const auto part = bytes_.subspan(offset_, count);
    offset_ += count;
    return part;
  }

  template <class T>
  T read(const char* what) {
    return load<T>(take(sizeof(T), what).data());
  }

 private:
  ByteSpan bytes_;
  std::function<std::string()> source_;
  std::uint64_t offset_ = 0;
};

// Appends and writes values as their little-endian bytes. byte_cursor.h reads them.

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
