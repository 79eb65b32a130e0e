// SPDX-License-Identifier: MIT
#include "io/picture/webp_image.h"

#include <webp/decode.h>
#include <webp/encode.h>

#include "base/fail.h"
#include "base/not_copied.h"
#include "base/progress.h"
#include "io/bytes/byte_text.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

const std::uint8_t* data_of(ByteSpan content) {
  return reinterpret_cast<const std::uint8_t*>(content.data());
}

struct WebpWriter : NotCopied {
  WebPPicture picture;
  WebPMemoryWriter memory;

  WebpWriter() {
    WebPPictureInit(&picture);
    WebPMemoryWriterInit(&memory);
  }
  ~WebpWriter() {
    WebPPictureFree(&picture);
    WebPMemoryWriterClear(&memory);
  }
};

int goes_on(int, const WebPPicture* picture) {
  return static_cast<const std::stop_token*>(picture->user_data)->stop_requested() ? 0 : 1;
}

// `level`: of libwebp's lossless presets, 0 to 9. Colours of transparent pixels are kept.
std::string encoded_webp(const RgbaPixels& pixels, const std::stop_token& stop, int level,
                         decltype(WebPPictureImportRGBA)& import) {
  WebPConfig config;
  WebPConfigInit(&config);
  WebPConfigLosslessPreset(&config, level);
  config.exact = 1;
  WebpWriter writer;
  writer.picture.use_argb = 1;
  writer.picture.width = pixels.width;
  writer.picture.height = pixels.height;
  writer.picture.writer = WebPMemoryWrite;
  writer.picture.custom_ptr = &writer.memory;
  std::stop_token asked = stop;
  writer.picture.user_data = &asked;
  writer.picture.progress_hook = goes_on;
  const bool encoded = import(&writer.picture, pixels.values.data(), 4 * pixels.width) != 0 &&
                       WebPEncode(&config, &writer.picture) != 0;
  if (!encoded && stop.stop_requested()) throw Cancelled();
  if (!encoded) fail(ErrorKind::device, "not enough memory to encode a picture");
  return {reinterpret_cast<const char*>(writer.memory.mem), writer.memory.size};
}

}  // namespace

WebpSize webp_size(ByteSpan content, const std::string& where) {
  constexpr int kLossy = 1;
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data_of(content), content.size(), &features) != VP8_STATUS_OK)
    fail("{}: not a WebP picture", where);
  if (features.has_animation != 0) fail("{}: an animation instead of a picture", where);
  if (features.format == kLossy) fail("{}: a lossy picture, which cannot hold exact values", where);
  return {static_cast<std::uint64_t>(features.width), static_cast<std::uint64_t>(features.height)};
}

Array<std::uint8_t> decode_webp(ByteSpan content, const std::string& where) {
  const WebpSize size = webp_size(content, where);
  Array<std::uint8_t> pixels(4 * size.pixels());
  const int stride = static_cast<int>(4 * size.width);  // at most 4 * 16383
  if (WebPDecodeRGBAInto(data_of(content), content.size(), pixels.data(), pixels.size(), stride) ==
      nullptr)
    fail("{}: the WebP picture is damaged", where);
  return pixels;
}

std::string encode_webp(const RgbaPixels& pixels, const std::stop_token& stop) {
  constexpr int kFastest = 0;
  return encoded_webp(pixels, stop, kFastest, WebPPictureImportRGBX);
}

std::string encode_data_webp(const RgbaPixels& pixels, const std::stop_token& stop) {
  constexpr int kUsual = 6;
  return encoded_webp(pixels, stop, kUsual, WebPPictureImportRGBA);
}

}  // namespace qs
