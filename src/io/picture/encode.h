// SPDX-License-Identifier: MIT
//
// Pictures as the bytes of a file, for browsers: JPEG while the camera moves, lossless WebP at
// rest. Writing files: image_file.h.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <string>

namespace qs {

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
