// SPDX-License-Identifier: MIT
//
// PPM (P6, also P5 gray: 8 or 16 bits, big endian, rows from the top) and PFM (PF colour, Pf gray:
// raw floats, rows from the bottom, byte order by the sign of the scale). Written PFM files are
// little endian.
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/picture/picture_formats.h"

namespace qs {
namespace {

// The four words before the pixels (magic, width, height, maximum or scale) and the offset of the
// pixels.
struct Header {
  std::array<std::string_view, 4> words;
  std::size_t end = 0;
};

Header read_header(std::string_view content, const std::filesystem::path& path) {
  const auto is_space = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
  Header header;
  std::size_t at = 0;
  for (std::string_view& word : header.words) {
    while (at < content.size() && (is_space(content[at]) || content[at] == '#')) {
      if (content[at] == '#') at = std::min(content.find('\n', at), content.size() - 1);
      ++at;
    }
    const std::size_t begin = at;
    while (at < content.size() && !is_space(content[at])) ++at;
    word = content.substr(begin, at - begin);
  }
  if (at >= content.size()) fail("{}: the picture's header is incomplete", path.string());
  header.end = at + 1;  // exactly one whitespace character precedes the pixels
  return header;
}

template <class T>
T parse(std::string_view word, const std::filesystem::path& path) {
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size())
    fail("{}: '{}' in the picture's header is not a number", path.string(), word.substr(0, 20));
  return value;
}

// An image of the size in the header, after checking that `content` holds its pixels.
Image make_image(const Header& header, std::string_view content, const std::filesystem::path& path,
                 int channels, int bytes_per_value) {
  const auto width = parse<std::int64_t>(header.words[1], path);
  const auto height = parse<std::int64_t>(header.words[2], path);
  check_picture_size(path, width, height, channels);
  const auto needed = static_cast<std::size_t>(width * height * channels * bytes_per_value);
  if (content.size() - header.end < needed)
    fail("{}: truncated: {} x {} pixels need {} bytes, {} are there", path.string(), width, height,
         needed, content.size() - header.end);
  return {static_cast<int>(width), static_cast<int>(height), channels};
}

void require_opaque(const Image& image, const PictureTarget& target) {
  if (image.channels == 1 || image.channels == 3) return;
  fail("{}: this format holds gray or RGB, not {} channels", target.shown.string(), image.channels);
}

float swapped(float value) {
  auto bytes = std::bit_cast<std::array<std::byte, sizeof value>>(value);
  std::ranges::reverse(bytes);
  return std::bit_cast<float>(bytes);
}

static_assert(std::endian::native == std::endian::little);

}  // namespace

Image read_ppm(const std::filesystem::path& path) {
  const std::string content = read_picture_bytes(path);
  const Header header = read_header(content, path);
  const bool color = header.words[0] == "P6";
  if (!color && header.words[0] != "P5")
    fail("{}: not a binary PPM: it does not begin with P6", path.string());
  const int maximum = parse<int>(header.words[3], path);
  if (maximum < 1 || maximum > 65535)
    fail("{}: a maximum value of {} is not allowed", path.string(), maximum);
  const int bytes_per_value = maximum > 255 ? 2 : 1;
  Image image = make_image(header, content, path, color ? 3 : 1, bytes_per_value);
  const auto* bytes = reinterpret_cast<const unsigned char*>(content.data() + header.end);
  for (float& value : image.values) {
    int stored = *bytes++;
    if (bytes_per_value == 2) stored = stored * 256 + *bytes++;
    value = static_cast<float>(stored) / static_cast<float>(maximum);
  }
  return image;
}

void write_ppm(const Image& image, const PictureTarget& target, const ImageMetadata&) {
  require_opaque(image, target);
  std::ofstream file = open_picture(target);
  file << (image.channels == 3 ? "P6\n" : "P5\n") << image.width << ' ' << image.height
       << "\n255\n";
  std::string bytes(image.values.size(), '\0');
  std::ranges::transform(image.values, bytes.begin(),
                         [](float value) { return static_cast<char>(to_8bit(value)); });
  file << bytes;
  close_picture(file, target);
}

Image read_pfm(const std::filesystem::path& path) {
  const std::string content = read_picture_bytes(path);
  const Header header = read_header(content, path);
  const bool color = header.words[0] == "PF";
  if (!color && header.words[0] != "Pf")
    fail("{}: not a PFM: it does not begin with PF", path.string());
  const auto scale = parse<double>(header.words[3], path);
  if (scale == 0 || !std::isfinite(scale))
    fail("{}: a scale of {} is not allowed", path.string(), scale);
  Image image = make_image(header, content, path, color ? 3 : 1, 4);

  const std::size_t row_bytes = static_cast<std::size_t>(image.width * image.channels) * 4;
  const std::size_t needed = row_bytes * static_cast<std::size_t>(image.height);
  if (content.size() - header.end != needed) {  // a PPM may hold several pictures, a PFM one
    fail("{}: {} x {} pixels need {} bytes, {} are there", path.string(), image.width, image.height,
         needed, content.size() - header.end);
  }
  for (int y = 0; y < image.height; ++y) {
    const std::size_t stored_row = static_cast<std::size_t>(image.height - 1 - y);
    std::memcpy(image.row(y), content.data() + header.end + stored_row * row_bytes, row_bytes);
  }
  if (scale > 0) std::ranges::transform(image.values, image.values.begin(), swapped);
  return image;
}

void write_pfm(const Image& image, const PictureTarget& target, const ImageMetadata&) {
  require_opaque(image, target);
  std::ofstream file = open_picture(target);
  file << (image.channels == 3 ? "PF\n" : "Pf\n") << image.width << ' ' << image.height
       << "\n-1.0\n";
  const auto row_values = static_cast<std::size_t>(image.width * image.channels);
  for (int y = image.height - 1; y >= 0; --y)
    write_values(file, std::span(image.row(y), row_values));
  close_picture(file, target);
}

}  // namespace qs
