// SPDX-License-Identifier: MIT
//
// An image in memory: rows from the top, pixels from the left, channels interleaved. Colours are in
// the space in which the model was trained (usually sRGB), nominally 0..1, not clamped.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace qs {

struct Image {
  int width = 0, height = 0, channels = 0;  ///< pixels, pixels, values per pixel
  std::vector<float> values;                ///< height * width * channels

  Image() = default;
  Image(int w, int h, int c)
      : width(w),
        height(h),
        channels(c),
        values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) *
               static_cast<std::size_t>(c)) {}

  float* row(int y) {
    return values.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width * channels);
  }
  const float* row(int y) const { return const_cast<Image*>(this)->row(y); }
  float& at(int x, int y, int c) { return row(y)[x * channels + c]; }
  float at(int x, int y, int c) const { return row(y)[x * channels + c]; }
};

/// All 8-bit output uses this rule: floor(255 * clamp(x, 0, 1) + 0.5); NaN becomes 0.
inline std::uint8_t to_8bit(float value) {
  return static_cast<std::uint8_t>(
      static_cast<int>(255.0f * std::min(std::max(0.0f, value), 1.0f) + 0.5f));
}

/// Peak signal-to-noise ratio in dB of two images of equal size, over their first `channels`
/// channels rounded to 8 bits (peak 255); +infinity if these are equal. In image_metrics.cpp.
double psnr_8bit(const Image& a, const Image& b, int channels = 3);

}  // namespace qs
