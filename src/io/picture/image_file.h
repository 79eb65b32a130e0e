// SPDX-License-Identifier: MIT
//
// Reads and writes pictures. .png (libpng), .ppm and .pfm are built in; every other format goes
// through the OpenImageIO module, which is loaded when first needed because it costs 0.2 s and 130
// MB. 8-bit output is floor(255 * clamp(x, 0, 1) + 0.5); values are stored as they are, no colour
// conversion.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "raster/scene/image.h"

namespace qs {

/// Written as text into formats that hold some (PNG tEXt, EXR attributes), ignored elsewhere.
using ImageMetadata = std::map<std::string, std::string>;

/// 1 to 4 channels as stored, integers scaled to 0..1. Throws Error(input), or Error(device) with a
/// sentence when the format needs the module and it cannot be loaded.
Image read_image(const std::filesystem::path& path);

/// The format follows the extension. The file appears whole or not at all. Throws like read_image.
void write_image(const Image& image, const std::filesystem::path& path,
                 const ImageMetadata& metadata = {});

}  // namespace qs
