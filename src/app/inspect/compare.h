// SPDX-License-Identifier: MIT
//
// Compares a rendered picture with one from a file, on the 8-bit RGB values that a file would hold.
#pragma once

#include <filesystem>

#include "raster/scene/image.h"

namespace qs {

struct Comparison {
  double psnr = 0;        ///< dB, +infinity when equal
  int largest = 0;        ///< largest difference of an 8-bit value
  int amplification = 1;  ///< of `difference`
  Image difference;       ///< |a - b| of the 8-bit values times amplification, RGB
};

/// Both need at least three channels and the same size.
Comparison compare(const Image& rendered, const Image& reference);

/// The picture at `path` as RGB of this size. Throws Error(input) for another size.
Image read_reference(const std::filesystem::path& path, int width, int height);

/// OUT.png -> OUT.difference.png, always a PNG.
std::filesystem::path difference_path(const std::filesystem::path& output);

}  // namespace qs
