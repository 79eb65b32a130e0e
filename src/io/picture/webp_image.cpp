// SPDX-License-Identifier: MIT
#include "io/picture/webp_image.h"

#include <webp/decode.h>

#include "base/fail.h"

namespace qs {
namespace {

const std::uint8_t* data_of(std::span<const std::byte> content) {
  return reinterpret_cast<const std::uint8_t*>(content.data());
}

}  // namespace

WebpSize webp_size(std::span<const std::byte> content, const std::string& where) {
  constexpr int kLossy = 1;
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data_of(content), content.size(), &features) != VP8_STATUS_OK) {
    fail("{}: not a WebP picture", where);
  }
  if (features.has_animation != 0) fail("{}: an animation instead of a picture", where);
  if (features.format == kLossy) fail("{}: a lossy picture, which cannot hold exact values", where);
  return {static_cast<std::uint64_t>(features.width), static_cast<std::uint64_t>(features.height)};
}

Array<std::uint8_t> decode_webp(std::span<const std::byte> content, const std::string& where) {
  const WebpSize size = webp_size(content, where);
  Array<std::uint8_t> pixels(4 * size.pixels());
  const int stride = static_cast<int>(4 * size.width);  // at most 4 * 16383
  if (WebPDecodeRGBAInto(data_of(content), content.size(), pixels.data(), pixels.size(), stride) ==
      nullptr) {
    fail("{}: the WebP picture is damaged", where);
  }
  return pixels;
}

}  // namespace qs
