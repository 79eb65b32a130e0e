// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <utility>

#include <glm/gtc/packing.hpp>

#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/scene/ply/ply_file.h"

namespace qs {
namespace {

// A number of half precision.
struct Half {
  std::uint16_t bits;
  explicit operator double() const { return static_cast<double>(glm::unpackHalf1x16(bits)); }
};

template <class T>
double load_as_double(const std::byte* at, bool swap) {
  if (!swap) return static_cast<double>(load<T>(at));
  std::array<std::byte, sizeof(T)> bytes;
  std::reverse_copy(at, at + sizeof(T), bytes.begin());
  return static_cast<double>(load<T>(bytes.data()));
}

double load_as_double(PlyType type, const std::byte* at, bool swap) {
  constexpr decltype(&load_as_double<float>) kLoads[] = {
      // index: PlyType
      load_as_double<std::int8_t>,   load_as_double<std::uint8_t>, load_as_double<std::int16_t>,
      load_as_double<std::uint16_t>, load_as_double<std::int32_t>, load_as_double<std::uint32_t>,
      load_as_double<Half>,          load_as_double<float>,        load_as_double<double>};
  return kLoads[static_cast<std::size_t>(type)](at, swap);
}

// The two encodings of a stream of numbers. number() and skip() return false if the bytes end or
// are not a number; `problem` then describes the defect.
struct BinaryNumbers {
  ByteSpan content;
  std::uint64_t offset;
  bool swap;
  std::string problem = "the file ends";

  bool number(PlyType type, double& value) {
    if (size_of(type) > content.size() - offset) return false;
    value = load_as_double(type, content.data() + offset, swap);
    offset += size_of(type);
    return true;
  }
  bool skip(PlyType type, std::uint64_t count) {
    if (!fits(count, size_of(type), content.size() - offset)) return false;
    offset += count * size_of(type);
    return true;
  }
};

struct AsciiNumbers {
  std::string_view text;
  std::uint64_t offset;
  std::string problem = "the file ends";

  // Line ends count as blanks: the body of an ascii .ply is a stream of words.
  std::string_view word() {
    const auto is_blank = [&](std::uint64_t at) {
      return text[at] == ' ' || (text[at] >= '\t' && text[at] <= '\r');
    };
    while (offset < text.size() && is_blank(offset)) ++offset;
    const std::uint64_t begin = offset;
    while (offset < text.size() && !is_blank(offset)) ++offset;
    return text.substr(begin, offset - begin);
  }
  bool number(PlyType, double& value) {
    constexpr std::size_t kLongest = 400;  // the longest double in plain decimals has about 330
    const std::string_view token = word();
    const std::string_view digits = token.substr(token.starts_with('+') ? 1 : 0, kLongest);
    const char* const end = token.data() + token.size();
    const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error == std::errc() && stop == end) return true;
    if (!token.empty()) problem = quoted_for_message(token) + " is not a number";
    return false;
  }
  bool skip(PlyType, std::uint64_t count) {
    while (count > 0 && !word().empty()) --count;
    return count == 0;
  }
};

// Walks over the rows of an element. The time is O(bytes) for any count that the header claims,
// because every row takes at least one byte. Stores scalars to `values` unless it is nullptr.
// Returns the defect of the rows, or an empty string.
template <class Numbers>
std::string walk(const PlyElement& element, Numbers& numbers, double* values,
                 const Progress& progress) {
  constexpr std::uint64_t kRowsPerReport = 1 << 16;
  if (element.properties.empty()) return {};
  for (std::uint64_t row = 0; row < element.count; ++row) {
    if (row % kRowsPerReport == 0)
      progress.update(static_cast<float>(row) / static_cast<float>(element.count) / 2);
    for (const PlyProperty& property : element.properties) {
      double length = 0;
      bool whole = false;
      if (property.is_list) {
        whole = numbers.number(property.length_type, length);
        if (whole && !(length >= 0 && length <= std::numeric_limits<std::uint32_t>::max()))
          return fmt::format("row {}: a list of length {}", row, length);
        whole = whole && numbers.skip(property.type, static_cast<std::uint64_t>(length));
      } else if (values == nullptr) {
        whole = numbers.skip(property.type, 1);
      } else {
        whole = numbers.number(property.type, *values++);
      }
      if (!whole) return fmt::format("row {} of {}: {}", row, element.count, numbers.problem);
    }
  }
  return {};
}

std::string announced(std::uint64_t rows, std::uint64_t row_bytes, std::uint64_t left) {
  return fmt::format("{} rows of at least {} bytes are announced, {} bytes are left", rows,
                     row_bytes, left);
}

struct Walked {
  std::uint64_t end;    // offset of the element's end
  std::string problem;  // empty if the element is complete
};

Walked walk(ByteSpan content, PlyFormat format, const PlyElement& element, std::uint64_t begin,
            double* values, const Progress& progress) {
  if (format == PlyFormat::ascii) {
    AsciiNumbers numbers{text_of(content), begin};
    std::string problem = walk(element, numbers, values, progress);
    return {numbers.offset, std::move(problem)};
  }
  if (!element.has_list && values == nullptr) {
    if (!fits(element.count, element.row_bytes, content.size() - begin))
      return {begin, announced(element.count, element.row_bytes, content.size() - begin)};
    return {begin + element.count * element.row_bytes, {}};
  }
  BinaryNumbers numbers{content, begin, format == PlyFormat::binary_big_endian};
  std::string problem = walk(element, numbers, values, progress);
  return {numbers.offset, std::move(problem)};
}

}  // namespace

const PlyColumn& PlyRows::of_vertices(std::string_view column, const std::string& path) const {
  const PlyColumn* const found = find(column);
  if (found == nullptr) fail("{}: the vertices have no property {}", path, column);
  return *found;
}

double PlyRows::value(std::uint64_t row, const PlyColumn& column) const {
  return load_as_double(column.type, data + row * row_bytes + column.offset, swap_bytes);
}

void PlyBody::refuse(const PlyElement& element, std::string_view problem) const {
  fail("{}: cut off or damaged in element {}: {}", path_, quoted_for_message(element.name),
       problem);
}

std::uint64_t PlyBody::begin_of(std::size_t element) {
  if (begins_.empty()) begins_.push_back(header_.body_offset);
  while (begins_.size() <= element) {
    const PlyElement& before = header_.elements[begins_.size() - 1];
    const auto [end, problem] =
        walk(content_, header_.format, before, begins_.back(), nullptr, progress_);
    if (!problem.empty()) refuse(before, problem);
    begins_.push_back(end);
  }
  return begins_[element];
}

PlyRows PlyBody::rows(std::string_view name) {
  const PlyElement* const element = header_.find(name);
  if (element == nullptr) fail("{}: has no element '{}'", path_, name);
  const auto index = static_cast<std::size_t>(element - header_.elements.data());
  const std::uint64_t begin = begin_of(index);
  const std::uint64_t left = content_.size() - begin;

  PlyRows rows;
  rows.count = element->count;
  for (const PlyProperty& property : element->properties)
    if (!property.is_list)
      rows.columns.push_back({property.name, property.type, property.offset, property.type});
  if (header_.format != PlyFormat::ascii && !element->has_list) {
    begin_of(index + 1);  // checks that no row is missing
    rows.data = content_.data() + begin;
    rows.row_bytes = element->row_bytes;
    rows.swap_bytes = header_.format == PlyFormat::binary_big_endian;
    return rows;
  }
  // A number takes at least one byte, and in ascii also a blank.
  const std::uint64_t row_bytes =
      element->properties.size() * (header_.format == PlyFormat::ascii ? 2 : 1);
  if (!fits(element->count, row_bytes, left + 1))
    refuse(*element, announced(element->count, row_bytes, left));
  for (std::size_t i = 0; i < rows.columns.size(); ++i) {
    rows.columns[i].type = PlyType::f64;
    rows.columns[i].offset = i * sizeof(double);
  }
  rows.row_bytes = rows.columns.size() * sizeof(double);
  // One more value than needed: data() of an empty array could be nullptr, and then nothing would
  // be decoded.
  rows.decoded.resize(element->count * rows.columns.size() + 1);
  const auto [end, problem] =
      walk(content_, header_.format, *element, begin, rows.decoded.data(), progress_);
  if (!problem.empty()) refuse(*element, problem);
  if (begins_.size() == index + 1) begins_.push_back(end);
  rows.data = reinterpret_cast<const std::byte*>(rows.decoded.data());
  return rows;
}

std::vector<std::string> PlyBody::leftovers() {
  std::uint64_t offset = begins_.empty() ? header_.body_offset : begins_.back();
  for (std::size_t i = begins_.empty() ? 0 : begins_.size() - 1; i < header_.elements.size(); ++i) {
    const PlyElement& element = header_.elements[i];
    const auto [end, problem] = walk(content_, header_.format, element, offset, nullptr, progress_);
    if (!problem.empty())
      return {fmt::format("Element {}, which is not needed, is cut off or damaged.",
                          quoted_for_message(element.name))};
    offset = end;
  }
  std::uint64_t rest = content_.size() - offset;
  if (header_.format == PlyFormat::ascii)
    if (AsciiNumbers{text_of(content_), offset}.word().empty()) rest = 0;
  if (rest == 0) return {};
  return {fmt::format("{} bytes after the last element were ignored.", rest)};
}

}  // namespace qs
