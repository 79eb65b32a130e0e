// SPDX-License-Identifier: MIT
//
// Pictures as video codecs take them: a plane of luma and two planes of chroma with half the width
// and height, in the limited range of ITU-R BT.601 (luma 16 to 235, chroma 16 to 240).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "io/picture/encode.h"

namespace qs {

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

}  // namespace qs
