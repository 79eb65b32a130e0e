// SPDX-License-Identifier: MIT
//
// Encodes the pictures of one visitor: JPEG or VP9 while the camera moves, lossless WebP at rest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>

#include "io/picture/image_file.h"
#include "io/picture/vp9.h"

namespace qs {

/// Index = the byte `codec` of a picture's header.
enum class PictureCodec : std::uint8_t { none, jpeg, webp, vp9 };

struct Encoding {
  PictureCodec codec = PictureCodec::jpeg;
  int quality = 90;         ///< of JPEG
  int bits_per_second = 0;  ///< of VP9
  std::uint32_t keys = 0;   ///< key pictures that the page has asked for so far
  int threads = 1;          ///< of VP9; a video keeps the number of its first picture
};

/// The threads of a visitor's video. The visitors share the processors, so a video has more threads
/// than one only while there are more processors than visitors.
int video_threads(std::size_t processors, std::size_t visitors);

struct EncodedPicture {
  PictureCodec codec = PictureCodec::none;
  std::string bytes;
  bool is_key = false;
  int quantizer = 0;  ///< of VP9
  double ms = 0;      ///< that it took
};

class PictureEncoder {
 public:
  /// `now`: seconds of one clock. After a failure of libvpx, for example without memory, moving
  /// pictures are JPEG. Throws Error(device), and Cancelled after a stop.
  EncodedPicture encode(const RgbaPixels& pixels, const Encoding& encoding, double now,
                        const std::stop_token& stop);

 private:
  // False after a failure.
  bool encode_vp9(const RgbaPixels& pixels, const Encoding& encoding, double now,
                  EncodedPicture& encoded);

  std::unique_ptr<Vp9Encoder> vp9_;  // for pictures of one size, without a codec between them
  bool vp9_failed_ = false;
  I420 planes_;
  double last_ = 0;         // time of the last picture of vp9_
  std::uint32_t keys_ = 0;  // Encoding::keys of that picture
};

}  // namespace qs
