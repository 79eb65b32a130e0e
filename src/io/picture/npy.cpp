// SPDX-License-Identifier: MIT
//
// NPY, the arrays of NumPy: height x width (gray) or height x width x channels, 32-bit floats,
// little endian, in C order, rows from the top.
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "io/picture/picture_formats.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view kMagic("\x93NUMPY", 6);
constexpr std::size_t kAlign = 64;  // of the values in the file

/// The text after "'key':" in the dictionary of the header; "" if there is none.
std::string_view value_of(std::string_view dictionary, std::string_view key) {
  const std::size_t at = dictionary.find(fmt::format("'{}':", key));
  if (at == std::string_view::npos) return {};
  const std::string_view rest = dictionary.substr(at + key.size() + 3);
  return rest.substr(std::min(rest.find_first_not_of(' '), rest.size()));
}

/// The numbers of a tuple such as "(480, 640)". Empty if the text is not a tuple.
std::vector<std::int64_t> numbers_of(std::string_view tuple) {
  std::vector<std::int64_t> numbers;
  const std::size_t end = tuple.find(')');
  if (!tuple.starts_with('(') || end == std::string_view::npos) return {};
  for (tuple = tuple.substr(1, end - 1); !tuple.empty();) {
    const std::size_t begin = tuple.find_first_not_of(", ");
    if (begin == std::string_view::npos) break;
    tuple.remove_prefix(begin);
    std::int64_t number = 0;
    const auto [stop, error] = std::from_chars(tuple.data(), tuple.data() + tuple.size(), number);
    if (error != std::errc()) return {};
    tuple.remove_prefix(static_cast<std::size_t>(stop - tuple.data()));
    numbers.push_back(number);
  }
  return numbers;
}

}  // namespace

Image read_npy(const std::filesystem::path& path) {
  const std::string content = read_picture_bytes(path);
  const std::size_t size_bytes = content.size() > 6 && content[6] == 1 ? 2 : 4;
  std::size_t begin = 8 + size_bytes;
  if (!content.starts_with(kMagic) || content.size() < begin)
    fail("{}: not an NPY file: it does not begin with \\x93NUMPY", path.string());
  std::uint32_t length = 0;
  std::memcpy(&length, content.data() + 8, size_bytes);
  if (length > content.size() - begin) fail("{}: the header is truncated", path.string());
  const std::string_view dictionary = std::string_view(content).substr(begin, length);
  begin += length;
  if (!value_of(dictionary, "descr").starts_with("'<f4'"))
    fail("{}: only arrays of little-endian 32-bit floats ('<f4') are supported", path.string());
  if (!value_of(dictionary, "fortran_order").starts_with("False"))
    fail("{}: only arrays in C order are supported", path.string());
  std::vector<std::int64_t> shape = numbers_of(value_of(dictionary, "shape"));
  if (shape.size() == 2) shape.push_back(1);
  if (shape.size() != 3)
    fail("{}: a picture has the shape (height, width) or (height, width, channels)", path.string());
  check_picture_size(path, shape[1], shape[0], shape[2]);
  Image image(static_cast<int>(shape[1]), static_cast<int>(shape[0]), static_cast<int>(shape[2]));
  const std::size_t needed = image.values.size() * sizeof(float);
  if (content.size() - begin > needed) {
    fail("{}: {} x {} pixels need {} bytes, {} are there", path.string(), shape[1], shape[0],
         needed, content.size() - begin);
  }
  if (content.size() - begin < needed) {
    fail("{}: truncated: {} x {} pixels need {} bytes, {} are there", path.string(), shape[1],
         shape[0], needed, content.size() - begin);
  }
  std::memcpy(image.values.data(), content.data() + begin, needed);
  return image;
}

void write_npy(const Image& image, const PictureTarget& target, const ImageMetadata&) {
  std::ofstream file = open_picture(target);
  const std::string channels = image.channels > 1 ? fmt::format(", {}", image.channels) : "";
  std::string header =
      fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}{}), }}", image.height,
                  image.width, channels);
  const std::size_t before = kMagic.size() + 4;
  header.append(kAlign - (before + header.size() + 1) % kAlign, ' ');
  header += '\n';
  const auto length = static_cast<std::uint16_t>(header.size());
  const std::array<char, 4> numbers = {1, 0, static_cast<char>(length & 0xff),
                                       static_cast<char>(length >> 8)};
  file.write(kMagic.data(), static_cast<std::streamsize>(kMagic.size()));
  file.write(numbers.data(), numbers.size());
  file.write(header.data(), static_cast<std::streamsize>(header.size()));
  file.write(reinterpret_cast<const char*>(image.values.data()),
             static_cast<std::streamsize>(image.values.size() * sizeof(float)));
  close_picture(file, target);
}

}  // namespace qs
