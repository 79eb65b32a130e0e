// SPDX-License-Identifier: MIT
//
// Reads and writes pictures. .png (libpng), .ppm, .pfm and .npy are built in, and so is reading
// .jpg (libjpeg-turbo). Every other format is read and written by the OpenImageIO module, which is
// loaded on first use because loading takes 0.2 s and 130 MB. Values are stored without colour
// conversion; 8-bit output is
//   floor(255 * clamp(x, 0, 1) + 0.5)
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <stop_token>
#include <string>

#include "base/progress.h"
#include "raster/scene/image.h"

namespace qs {

/// Stored as text in formats that support it (PNG tEXt, EXR attributes), ignored elsewhere.
using ImageMetadata = std::map<std::string, std::string>;

/// The entry that names the channel of an EXR file with one channel; without this entry it is "Y".
/// Other programs look for depth in "Z" and for alpha in "A".
inline constexpr const char* kChannelText = "Channel";

/// Returns 1 to 4 channels as stored, integers scaled to 0..1. Throws Error(input), or
/// Error(device) if the format needs the module and it cannot be loaded.
Image read_image(const std::filesystem::path& path);

/// The bytes of a PNG file, as write_image() writes it. Throws Error(device) when memory runs out.
std::string encode_png(const Image& image, const ImageMetadata& metadata = {});

/// Throws Error(usage) if the name has no ending, which chooses the format. Long commands ask
/// before they work.
void check_picture_name(const std::filesystem::path& path);

/// The format follows the extension. The file appears whole or not at all. Writing cannot be
/// stopped, and the report must not throw. Throws like read_image.
void write_image(const Image& image, const std::filesystem::path& path,
                 const ImageMetadata& metadata = {}, const Progress& progress = {});

/// As write_image(), a PNG with 16 bits per value: floor(65535 * clamp(x, 0, 1) + 0.5).
void write_16_bit_png(const Image& image, const std::filesystem::path& path,
                      const ImageMetadata& metadata = {}, const Progress& progress = {});

/// The EXIF orientation of a JPEG or PNG, 1 to 8; 1, upright, if there is none. Pictures are read
/// as they are stored.
int exif_orientation(const std::filesystem::path& path);
int exif_orientation(std::span<const std::byte> picture);

/// The extension in lower case, such as ".png", with .jpg for .jpeg.
std::string picture_extension(const std::filesystem::path& path);

// Pictures as the bytes of a file, for browsers: JPEG while the camera moves, lossless WebP at
// rest. Writing files: image_file.h.

/// 8-bit RGBA, rows from the top; the alpha is ignored. 4 * width * height values.
struct RgbaPixels {
  std::span<const std::uint8_t> values;
  int width = 0, height = 0;  ///< 1 to 16,383
};

/// `quality`: 1 to 100. Throws Error(device) when memory runs out.
std::string encode_jpeg(const RgbaPixels& pixels, int quality);

/// Lossless: decoders give exactly these colours. Throws Error(device) when memory runs out, and
/// Cancelled after a stop.
std::string encode_webp(const RgbaPixels& pixels, const std::stop_token& stop = {});

}  // namespace qs
