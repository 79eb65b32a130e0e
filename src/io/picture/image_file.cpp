// SPDX-License-Identifier: MIT
#include "io/picture/image_file.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "base/fail.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/picture/picture_formats.h"

namespace qs {
namespace {

constexpr std::array kFormats = {
    PictureFormat{".png", read_png, write_png}, PictureFormat{".jpg", read_jpeg, write_with_module},
    PictureFormat{".ppm", read_ppm, write_ppm}, PictureFormat{".pfm", read_pfm, write_pfm},
    PictureFormat{".npy", read_npy, write_npy},
};

// The fallback for all other extensions.
constexpr PictureFormat kModule{"", read_with_module, write_with_module};

const PictureFormat& format_of(const std::filesystem::path& path) {
  const std::string extension = picture_extension(path);
  const auto found = std::find_if(kFormats.begin(), kFormats.end(), [&](const PictureFormat& row) {
    return extension == row.extension;
  });
  return found == kFormats.end() ? kModule : *found;
}

void write_by(WritePicture* write, const Image& image, const std::filesystem::path& path,
              const ImageMetadata& metadata, const Progress& progress) {
  assert(image.width > 0 && image.height > 0 && image.channels >= 1 && image.channels <= 4);
  replace_file(path, [&](const std::filesystem::path& temporary) {
    write(image, {temporary, path, progress}, with_software(metadata));
  });
}

}  // namespace

std::span<const PictureFormat> picture_formats() { return kFormats; }

std::string picture_extension(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  return extension == ".jpeg" ? ".jpg" : extension;
}

ImageMetadata with_software(ImageMetadata metadata) {
  metadata.emplace("Software", "quadsplat");
  return metadata;
}

std::string read_picture_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) fail("{}: cannot be opened", path.string());
  std::ostringstream content;
  content << file.rdbuf();  // in blocks, also from pipes
  return std::move(content).str();
}

std::ofstream open_picture(const PictureTarget& target) {
  std::ofstream file(target.file, std::ios::binary);
  if (!file) fail("{}: cannot be written: the folder does not allow it", target.shown.string());
  errno = 0;
  return file;
}

void close_picture(std::ofstream& file, const PictureTarget& target) {
  file.close();
  if (!file) fail_to_write(target.shown, target.file);
}

void check_picture_size(const std::filesystem::path& path, std::int64_t width, std::int64_t height,
                        std::int64_t channels) {
  constexpr std::int64_t kMaxSide = 65535;
  constexpr std::int64_t kMaxValues = std::int64_t{1} << 29;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
    fail("{}: a picture of {} x {} pixels is not between 1 x 1 and {} x {}", path.string(), width,
         height, kMaxSide, kMaxSide);
  if (channels < 1 || channels > 4)
    fail("{}: {} channels, but 1 to 4 are supported", path.string(), channels);
  if (width * height * channels > kMaxValues)
    fail("{}: a picture of {} x {} pixels is too large", path.string(), width, height);
}

Image read_image(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) fail("{}: no such file", path.string());
  if (!std::filesystem::is_regular_file(path, error)) fail("{}: not a file", path.string());
  note_input(path);
  return format_of(path).read(path);
}

void check_picture_name(const std::filesystem::path& path) {
  if (path.extension().empty())
    fail(ErrorKind::usage, "{}: the name needs an ending such as .png that tells the format",
         path.string());
}

void write_image(const Image& image, const std::filesystem::path& path,
                 const ImageMetadata& metadata, const Progress& progress) {
  check_picture_name(path);
  write_by(format_of(path).write, image, path, metadata, progress);
}

void write_16_bit_png(const Image& image, const std::filesystem::path& path,
                      const ImageMetadata& metadata, const Progress& progress) {
  write_by(write_png_16, image, path, metadata, progress);
}

}  // namespace qs
