// SPDX-License-Identifier: MIT
//
// The picture formats behind image_file.h. Readers get a path that exists. Writers may get a
// temporary path and name `shown` in their messages. Sizes in headers are checked by
// check_picture_size() before pixels are allocated.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>

#include "io/picture/image_file.h"

namespace qs {

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
/// A C stream, for libraries that need one.
using File = std::unique_ptr<std::FILE, FileCloser>;

/// The path to write to, and the file name that the user gave.
struct PictureTarget {
  const std::filesystem::path& file;
  const std::filesystem::path& shown;
  const Progress& progress;  ///< reported by formats that take long
};

/// A format that is read without the module; image_file.cpp has one row per format. To add a
/// format: write NAME.cpp with both functions, declare them here, add the row.
struct PictureFormat {
  const char* extension;  ///< ".png", lower case
  Image (*read)(const std::filesystem::path& path);
  void (*write)(const Image& image, const PictureTarget& target, const ImageMetadata& metadata);
};

std::span<const PictureFormat> picture_formats();

/// Adds the text by which this program recognises its own pictures (io/bytes/file_guard.h).
ImageMetadata with_software(ImageMetadata metadata);

// For formats that are written through a stream.
std::string read_picture_bytes(const std::filesystem::path& path);
std::ofstream open_picture(const PictureTarget& target);
/// Throws Error(input) unless everything was written.
void close_picture(std::ofstream& file, const PictureTarget& target);

Image read_png(const std::filesystem::path& path);
void write_png(const Image& image, const PictureTarget& target, const ImageMetadata& metadata);
void write_png_16(const Image& image, const PictureTarget& target, const ImageMetadata& metadata);

Image read_jpeg(const std::filesystem::path& path);

Image read_ppm(const std::filesystem::path& path);
void write_ppm(const Image& image, const PictureTarget& target, const ImageMetadata&);
Image read_pfm(const std::filesystem::path& path);
void write_pfm(const Image& image, const PictureTarget& target, const ImageMetadata&);

Image read_npy(const std::filesystem::path& path);
void write_npy(const Image& image, const PictureTarget& target, const ImageMetadata&);

/// With the OpenImageIO module: every other format, and writing JPEG.
Image read_with_module(const std::filesystem::path& path);
void write_with_module(const Image& image, const PictureTarget& target,
                       const ImageMetadata& metadata);

/// Throws Error(input) unless 1 <= width, height <= 65,535, 1 <= channels <= 4 and the values fit
/// into 2 GiB.
void check_picture_size(const std::filesystem::path& path, std::int64_t width, std::int64_t height,
                        std::int64_t channels);

}  // namespace qs
