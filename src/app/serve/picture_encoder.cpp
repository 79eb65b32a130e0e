// SPDX-License-Identifier: MIT
#include "app/serve/picture_encoder.h"

#include <chrono>
#include <utility>

namespace qs {

EncodedPicture PictureEncoder::encode(const RgbaPixels& pixels, const Encoding& encoding,
                                      double now, const std::stop_token& stop) {
  const auto began = std::chrono::steady_clock::now();
  EncodedPicture encoded;
  if (encoding.codec == PictureCodec::vp9) {
    encoded = encode_vp9(pixels, encoding, now);
  } else if (encoding.codec == PictureCodec::webp) {
    encoded.bytes = encode_webp(pixels, stop);
  } else {
    vp9_.reset();  // it begins again with a key picture
    encoded.bytes = encode_jpeg(pixels, encoding.quality);
  }
  encoded.codec = encoding.codec;
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - began;
  encoded.ms = spent.count();
  return encoded;
}

EncodedPicture PictureEncoder::encode_vp9(const RgbaPixels& pixels, const Encoding& encoding,
                                          double now) {
  if (!vp9_ || vp9_->width() != pixels.width || vp9_->height() != pixels.height) {
    vp9_.reset();  // the old one's memory may be needed
    vp9_ = std::make_unique<Vp9Encoder>(pixels.width, pixels.height);
  }
  planes_.set(pixels);
  Vp9Picture picture;
  try {
    picture = vp9_->encode(planes_, now - std::exchange(last_, now), encoding.bits_per_second,
                           encoding.keys != std::exchange(keys_, encoding.keys));
  } catch (...) {
    vp9_.reset();  // pictures after a lost one could not be decoded
    throw;
  }
  EncodedPicture encoded;
  encoded.bytes = std::move(picture.bytes);
  encoded.is_key = picture.is_key;
  encoded.quantizer = picture.quantizer;
  return encoded;
}

}  // namespace qs
