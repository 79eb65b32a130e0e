// SPDX-License-Identifier: MIT
//
// Encodes moving pictures as VP9 with libvpx, for a line without loss: each picture refers to the
// one before it, and only key pictures can be decoded alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/picture/image_file.h"

namespace qs {

// Pictures as video codecs take them: a plane of luma and two planes of chroma with half the width
// and height, in the limited range of ITU-R BT.601 (luma 16 to 235, chroma 16 to 240).

class I420 {
 public:
  int width() const { return width_; }
  int height() const { return height_; }
  int chroma_width() const { return (width_ + 1) / 2; }
  int chroma_height() const { return (height_ + 1) / 2; }

  /// Bytes between rows.
  std::size_t stride() const { return stride_; }
  std::size_t chroma_stride() const { return stride_ / 2; }

  /// Rows from the top.
  const std::uint8_t* y() const { return values_.data(); }
  const std::uint8_t* u() const { return y() + stride_ * rows(); }
  const std::uint8_t* v() const { return u() + chroma_stride() * rows() / 2; }

  /// Takes the colours of a picture. Chroma is the mean of four pixels; the last column and row are
  /// repeated where the size is odd. Values are within 1 of the exact ones.
  void set(const RgbaPixels& pixels);

 private:
  std::size_t rows() const { return 2 * static_cast<std::size_t>(chroma_height()); }

  int width_ = 0, height_ = 0;
  std::size_t stride_ = 0;
  std::vector<std::uint8_t> values_;
  std::vector<std::int16_t> sums_;  // sums over two rows: red, green, blue
};

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
