// SPDX-License-Identifier: MIT
//
// The picture formats that image_file.cpp dispatches to. Readers get a path that exists; writers
// write to a path that may already be a temporary one, and name `shown` in their messages. Whatever
// a header claims is checked by check_picture_size() before pixels are allocated.
#pragma once

#include <cstdint>
#include <filesystem>

#include "io/picture/image_file.h"

namespace qs {

/// Where to write, and the name of the file that the user asked for.
struct PictureTarget {
  const std::filesystem::path& file;
  const std::filesystem::path& shown;
};

Image read_png(const std::filesystem::path& path);
void write_png(const Image& image, const PictureTarget& target, const ImageMetadata& metadata);

Image read_ppm(const std::filesystem::path& path);
void write_ppm(const Image& image, const PictureTarget& target);
Image read_pfm(const std::filesystem::path& path);
void write_pfm(const Image& image, const PictureTarget& target);

/// Every other format, through the OpenImageIO module.
Image read_with_module(const std::filesystem::path& path);
void write_with_module(const Image& image, const PictureTarget& target,
                       const ImageMetadata& metadata);

/// Throws Error(input) unless 1 <= width, height <= 65,535, 1 <= channels <= 4 and the values fit
/// into 2 GiB.
void check_picture_size(const std::filesystem::path& path, std::int64_t width, std::int64_t height,
                        std::int64_t channels);

}  // namespace qs
