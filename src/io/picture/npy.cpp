// SPDX-License-Identifier: MIT
//
// NPY, the arrays of NumPy: height x width (gray) or height x width x channels, 32-bit floats,
// little endian, in C order, rows from the top.
#include "io/tensor/npy.h"

#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/picture/picture_formats.h"

namespace qs {
constexpr std::string_view kType = "<f4";

Image read_npy(const std::filesystem::path& path) {
  const std::string content = read_picture_bytes(path);
  const NpyHeader header = parse_npy_header(content, path.string());
  if (header.type != kType)
    fail("{}: only arrays of little-endian 32-bit floats ('<f4') are supported", path.string());
  if (!header.is_c_order) fail("{}: only arrays in C order are supported", path.string());
  const std::size_t begin = header.size;
  std::vector<std::int64_t> shape = header.shape.value_or(std::vector<std::int64_t>());
  if (shape.size() == 2) shape.push_back(1);
  if (shape.size() != 3)
    fail("{}: a picture has the shape (height, width) or (height, width, channels)", path.string());
  check_picture_size(path, shape[1], shape[0], shape[2]);
  Image image(static_cast<int>(shape[1]), static_cast<int>(shape[0]), static_cast<int>(shape[2]));
  const std::size_t needed = image.values.size() * sizeof(float);
  if (const std::size_t there = content.size() - begin; there != needed)
    fail("{}: {}{} x {} pixels need {} bytes, {} are there", path.string(),
         there < needed ? "truncated: " : "", shape[1], shape[0], needed, there);
  std::memcpy(image.values.data(), content.data() + begin, needed);
  return image;
}

void write_npy(const Image& image, const PictureTarget& target, const ImageMetadata&) {
  std::ofstream file = open_picture(target);
  const std::string channels = image.channels > 1 ? fmt::format(", {}", image.channels) : "";
  file << npy_header(kType, fmt::format("({}, {}{})", image.height, image.width, channels));
  write_values(file, image.values);
  close_picture(file, target);
}

}  // namespace qs
