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

using ReadPicture = Image(const std::filesystem::path& path);
using WritePicture = void(const Image& image, const PictureTarget& target,
                          const ImageMetadata& metadata);

/// A format that is read without the module; image_file.cpp has one row per format. To add a
/// format: write NAME.cpp with both functions, declare them here, add the row.
struct PictureFormat {
  const char* extension;  ///< ".png", lower case
  ReadPicture* read;
  WritePicture* write;
};

std::span<const PictureFormat> picture_formats();

/// Adds the text by which this program recognises its own pictures (io/bytes/file_guard.h).
ImageMetadata with_software(ImageMetadata metadata);

// For formats that are written through a stream.
std::string read_picture_bytes(const std::filesystem::path& path);
std::ofstream open_picture(const PictureTarget& target);
/// Throws Error(input) unless everything was written.
void close_picture(std::ofstream& file, const PictureTarget& target);

ReadPicture read_png, read_jpeg, read_ppm, read_pfm, read_npy;
WritePicture write_png, write_png_16, write_ppm, write_pfm, write_npy;
/// With the OpenImageIO module: every other format, and writing JPEG.
ReadPicture read_with_module;
WritePicture write_with_module;

/// Throws Error(input) unless 1 <= width, height <= 65,535, 1 <= channels <= 4 and the values fit
/// into 2 GiB.
void check_picture_size(const std::filesystem::path& path, std::int64_t width, std::int64_t height,
                        std::int64_t channels);

}  // namespace qs
