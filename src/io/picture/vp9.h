// SPDX-License-Identifier: MIT
//
// Encodes moving pictures as VP9 with libvpx, for a line without loss: each picture refers to the
// one before it, and only key pictures can be decoded alone.
#pragma once

#include <memory>
#include <string>

#include "io/picture/i420.h"

namespace qs {

/// True if the program was built with libvpx.
bool has_vp9();

/// The quantisers of pictures are in this range; a larger one is coarser.
inline constexpr int kLeastQuantizer = 4, kMostQuantizer = 56;

struct Vp9Picture {
  std::string bytes;
  bool is_key = false;
  int quantizer = 0;
};

class Vp9Encoder {
 public:
  /// For pictures of this size, 1 to 16,384 pixels along each side. At most `threads` threads
  /// encode a picture, one for each of its tile columns: VP9 allows as many columns as have 256
  /// pixels each, and 4 are used. Throws Error(device) without libvpx and when memory runs out.
  Vp9Encoder(int width, int height, int threads = 1);
  ~Vp9Encoder();

  int width() const;
  int height() const;
  int threads() const;

  /// Encodes the next picture, `seconds` after the picture before it: it gets that part of the bits
  /// of a second, at least 1/60 and at most 1/20. The rate is limited to 1 kbit/s to 100 Mbit/s.
  /// The first picture is a key picture, and so is one with `key`. Throws Error(device) when memory
  /// runs out.
  Vp9Picture encode(const I420& picture, double seconds, int bits_per_second, bool key);

 private:
  struct Codec;
  std::unique_ptr<Codec> codec_;
};

}  // namespace qs
