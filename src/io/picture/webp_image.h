// SPDX-License-Identifier: MIT
//
// Decodes and encodes lossless WebP pictures whose pixels are data, as SOG stores them: straight
// (not premultiplied) RGBA. Size and kind are read from the header before anything is allocated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <string>

#include "io/bytes/byte_text.h"
#include "io/picture/image_file.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

struct WebpSize {
  std::uint64_t width = 0, height = 0;

  std::uint64_t pixels() const { return width * height; }
};

/// Throws Error(input) "where: ..." for data that is not a still, lossless WebP picture.
WebpSize webp_size(ByteSpan content, const std::string& where);

/// The pixels, 4 bytes each, rows from the top. Throws Error(input).
Array<std::uint8_t> decode_webp(ByteSpan content, const std::string& where);

/// Lossless, with the alpha: decode_webp() gives exactly these values. Smaller and slower than
/// encode_webp(). Throws Error(device) when memory runs out, and Cancelled after a stop.
std::string encode_data_webp(const RgbaPixels& pixels, const std::stop_token& stop = {});

}  // namespace qs
