// SPDX-License-Identifier: MIT
#include "io/tensor/npy.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"

namespace qs {
namespace {

constexpr std::string_view kMagic("\x93NUMPY", 6);
constexpr std::size_t kAlign = 64;  // the values begin at a multiple of it

/// The text after "'key':" in the dictionary of the header; "" if there is none.
std::string_view value_of(std::string_view dictionary, std::string_view key) {
  const std::size_t at = dictionary.find(fmt::format("'{}':", key));
  if (at == std::string_view::npos) return {};
  const std::string_view rest = dictionary.substr(at + key.size() + 3);
  return rest.substr(std::min(rest.find_first_not_of(' '), rest.size()));
}

/// The numbers of a tuple such as "(480, 640)".
std::optional<std::vector<std::int64_t>> numbers_of(std::string_view tuple) {
  std::vector<std::int64_t> numbers;
  const std::size_t end = tuple.find(')');
  if (!tuple.starts_with('(') || end == std::string_view::npos) return std::nullopt;
  for (tuple = tuple.substr(1, end - 1); !tuple.empty();) {
    const std::size_t begin = tuple.find_first_not_of(", ");
    if (begin == std::string_view::npos) break;
    tuple.remove_prefix(begin);
    std::int64_t number = 0;
    const auto [stop, error] = std::from_chars(tuple.data(), tuple.data() + tuple.size(), number);
    if (error != std::errc()) return std::nullopt;
    tuple.remove_prefix(static_cast<std::size_t>(stop - tuple.data()));
    numbers.push_back(number);
  }
  return numbers;
}

// Bytes of a value of a type such as "<f4"; 0 if it is not known.
std::uint64_t item_bytes(std::string_view type) {
  for (const std::string_view known :
       {"|i1", "|u1", "<i2", "<u2", "<f2", "<i4", "<u4", "<f4", "<i8", "<u8", "<f8"})
    if (type == known) return static_cast<std::uint64_t>(known[2] - '0');
  return 0;
}

}  // namespace

NpyHeader parse_npy_header(std::string_view content, const std::string& source) {
  const std::size_t size_bytes = content.size() > 6 && content[6] == 1 ? 2 : 4;
  const std::size_t begin = 8 + size_bytes;
  if (!content.starts_with(kMagic) || content.size() < begin)
    fail("{}: not an NPY file: it does not begin with \\x93NUMPY", source);
  std::uint32_t length = 0;
  std::memcpy(&length, content.data() + 8, size_bytes);
  if (length > content.size() - begin) fail("{}: the header is truncated", source);
  const std::string_view dictionary = content.substr(begin, length);
  NpyHeader header;
  const std::string_view type = value_of(dictionary, "descr");
  if (type.starts_with('\''))
    header.type = type.substr(1, std::min(type.find('\'', 1), type.size()) - 1);
  header.is_c_order = value_of(dictionary, "fortran_order").starts_with("False");
  header.shape = numbers_of(value_of(dictionary, "shape"));
  header.size = begin + length;
  return header;
}

std::string npy_header(std::string_view type, std::string_view shape) {
  std::string text =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type, shape);
  const std::size_t before = kMagic.size() + 4;
  text.append(kAlign - (before + text.size() + 1) % kAlign, ' ');
  text += '\n';
  std::string header(kMagic);
  header += {1, 0, static_cast<char>(text.size() & 0xff), static_cast<char>(text.size() >> 8)};
  return header + text;
}

std::uint64_t NpyArray::count() const {
  std::uint64_t count = 1;
  for (const std::uint64_t side : shape) count *= side;
  return count;
}

NpyArray parse_npy(ByteSpan content, const std::string& source) {
  const NpyHeader header = parse_npy_header(text_of(content), source);
  if (!header.shape) fail("{}: its shape is not a tuple of whole numbers", source);
  NpyArray array{header.type, {}, content.subspan(header.size)};
  for (const std::int64_t side : *header.shape) {
    if (side < 0) fail("{}: a side of its shape is {}", source, side);
    array.shape.push_back(static_cast<std::uint64_t>(side));
  }
  if (array.type == "|O") return array;
  const std::uint64_t item = item_bytes(array.type);
  if (item == 0) fail("{}: its values have a type that is not read", source);
  if (!header.is_c_order && array.shape.size() > 1)
    fail("{}: only arrays in C order are read", source);
  std::uint64_t count = 1;
  const std::uint64_t stored = array.values.size() / item;
  bool complete = true;
  for (const std::uint64_t side : array.shape) {
    complete = complete && fits(count, side, stored);
    if (complete) count *= side;
  }
  if (!complete || count * item != array.values.size())
    fail("{}: its shape does not fit its {} bytes of values", source, array.values.size());
  return array;
}

}  // namespace qs
