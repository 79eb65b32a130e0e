// SPDX-License-Identifier: MIT
#include "app/serve/picture_encoder.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "base/seconds.h"

namespace qs {

constexpr std::size_t kMostThreads = 4;  ///< as many as a video has tile columns

int video_threads(std::size_t processors, std::size_t visitors) {
  const std::size_t each = processors / std::max<std::size_t>(1, visitors);
  return static_cast<int>(std::clamp<std::size_t>(each, 1, kMostThreads));
}

EncodedPicture PictureEncoder::encode(const RgbaPixels& pixels, const Encoding& encoding,
                                      double now, const std::stop_token& stop) {
  const auto began = std::chrono::steady_clock::now();
  EncodedPicture encoded;
  encoded.codec = encoding.codec;
  if (encoding.codec == PictureCodec::webp) {
    encoded.bytes = encode_webp(pixels, stop);
  } else if (encoding.codec != PictureCodec::vp9 || !encode_vp9(pixels, encoding, now, encoded)) {
    vp9_.reset();  // it begins again with a key picture
    encoded.codec = PictureCodec::jpeg;
    encoded.bytes = encode_jpeg(pixels, encoding.quality);
  }
  encoded.ms = milliseconds_since(began);
  return encoded;
}

bool PictureEncoder::encode_vp9(const RgbaPixels& pixels, const Encoding& encoding, double now,
                                EncodedPicture& encoded) {
  if (vp9_failed_) return false;
  try {
    if (!vp9_ || vp9_->width() != pixels.width || vp9_->height() != pixels.height) {
      vp9_.reset();  // the old encoder's memory may be needed
      vp9_ = std::make_unique<Vp9Encoder>(pixels.width, pixels.height, encoding.threads);
    }
    planes_.set(pixels);
    Vp9Picture picture =
        vp9_->encode(planes_, now - std::exchange(last_, now), encoding.bits_per_second,
                     encoding.keys != std::exchange(keys_, encoding.keys));
    encoded.bytes = std::move(picture.bytes);
    encoded.is_key = picture.is_key;
    encoded.quantizer = picture.quantizer;
    return true;
  } catch (const std::exception&) {
    vp9_failed_ = true;
    return false;
  }
}

}  // namespace qs
