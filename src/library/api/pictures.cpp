// SPDX-License-Identifier: MIT
//
// Files of pictures.
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/picture/image_file.h"
#include "library/check/arrays.h"

struct QsPictureFile {
  qs::Image image;
};

using namespace qs::library;

namespace {

constexpr std::int64_t kMostChannels = 4;
constexpr std::int64_t kMostPixelsOfASide = 65535;

/// The values of the array, 8-bit values as value / 255. Throws Error(usage).
Image image_to_save(const QsArray& array, const Where& where) {
  check_dimensions(array, where, array.dimensions == 2 ? 2 : 3);
  const std::int64_t height = array.sizes[0], width = array.sizes[1];
  const std::int64_t channels = array.dimensions == 2 ? 1 : array.sizes[2];
  if (width < 1 || height < 1 || width > kMostPixelsOfASide || height > kMostPixelsOfASide)
    refuse(where, "{} x {} pixels are not between 1 x 1 and {} x {}", width, height,
           kMostPixelsOfASide, kMostPixelsOfASide);
  if (channels < 1 || channels > kMostChannels)
    refuse(where, "{} channels are not between 1 and {}", channels, kMostChannels);
  check_array(array, where, std::span(array.sizes, array.dimensions), kColors, Access::reads);
  ThreadPool alone(1);
  return image_of(array, alone);
}

}  // namespace

int32_t qs_picture_open(const char* path, QsPictureFile** picture, QsArray* values, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require(picture, {function, "picture"});
    *picture = nullptr;
    require_all(function, {{"path", path}, {"values", values}});
    *picture = new QsPictureFile{read_image(path)};
    const Image& image = (*picture)->image;
    *values = view_of(image.values.data(), static_cast<std::size_t>(image.height), QS_FLOAT32,
                      image.width, std::int64_t{image.width} * image.channels);
    values->dimensions = 3;
    values->sizes[2] = image.channels;
    values->strides[1] = image.channels;
    values->strides[2] = 1;
  });
}

void qs_picture_close(QsPictureFile* picture) { delete picture; }

int32_t qs_picture_save(const QsArray* values, const char* path, uint32_t overwrite,
                        char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require_all(function, {{"values", values}, {"path", path}});
    if (overwrite > 1) refuse({function, "overwrite"}, "is {}", overwrite);
    const Image image = image_to_save(*values, {function, "values"});
    const FileGuard guard(overwrite == 1, kOverwriteOption, GuardScope::thread);
    check_picture_name(path);
    check_targets({path});
    write_image(image, path);
  });
}
