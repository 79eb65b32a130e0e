// SPDX-License-Identifier: MIT
#include "io/picture/image_file.h"

#include <algorithm>
#include <cassert>
#include <cctype>
#include <system_error>

#include "io/bytes/replace_file.h"
#include "io/picture/picture_formats.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

}  // namespace

void check_picture_size(const std::filesystem::path& path, std::int64_t width, std::int64_t height,
                        std::int64_t channels) {
  constexpr std::int64_t kMaxSide = 65535;
  constexpr std::int64_t kMaxValues = std::int64_t{1} << 29;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    fail("{}: a picture of {} x {} pixels is not between 1 x 1 and {} x {}", path.string(), width,
         height, kMaxSide, kMaxSide);
  }
  if (channels < 1 || channels > 4) {
    fail("{}: {} channels, but 1 to 4 are supported", path.string(), channels);
  }
  if (width * height * channels > kMaxValues) {
    fail("{}: a picture of {} x {} pixels is too large", path.string(), width, height);
  }
}

Image read_image(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) fail("{}: no such file", path.string());
  if (!std::filesystem::is_regular_file(path, error)) fail("{}: not a file", path.string());
  const std::string extension = lower_extension(path);
  if (extension == ".png") return read_png(path);
  if (extension == ".ppm") return read_ppm(path);
  if (extension == ".pfm") return read_pfm(path);
  return read_with_module(path);
}

void write_image(const Image& image, const std::filesystem::path& path,
                 const ImageMetadata& metadata) {
  assert(image.width > 0 && image.height > 0 && image.channels >= 1 && image.channels <= 4);
  const std::string extension = lower_extension(path);
  if (extension.empty()) {
    fail(ErrorKind::usage, "{}: the name needs an ending such as .png that tells the format",
         path.string());
  }
  replace_file(path, [&](const std::filesystem::path& temporary) {
    const PictureTarget target{temporary, path};
    if (extension == ".png") return write_png(image, target, metadata);
    if (extension == ".ppm") return write_ppm(image, target);
    if (extension == ".pfm") return write_pfm(image, target);
    write_with_module(image, target, metadata);
  });
}

}  // namespace qs
