// SPDX-License-Identifier: MIT
//
// Half precision (IEEE binary16) without special hardware. Infinities and NaN have no half here.
#pragma once

#include <cstdint>
#include <cstring>

#include "raster/kernel/hd.h"

namespace qs {

// A half has 5 bits for the exponent and a bias of 15, a float 8 and 127. Shifting a half's bits
// into a float divides its value by 2^112; that is exact for subnormal halves too.
inline constexpr int kHalfShift = 13;

QS_HD float float_of_half(std::uint16_t half) {
  constexpr float kScale = 0x1p112f;
  const std::uint32_t bits = (half & 0x8000u) << 16 | static_cast<std::uint32_t>(half & 0x7fffu)
                                                          << kHalfShift;
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value * kScale;
}

/// True if a half equals `value`; it is then stored in `half`.
QS_HD bool to_half(float value, std::uint16_t& half) {
  constexpr float kScale = 0x1p-112f, kLargest = 65504;
  if (!(value >= -kLargest && value <= kLargest)) return false;
  const float scaled = value * kScale;
  std::uint32_t bits;
  std::memcpy(&bits, &scaled, sizeof bits);
  half = static_cast<std::uint16_t>((bits >> 16 & 0x8000u) | (bits >> kHalfShift & 0x7fffu));
  return float_of_half(half) == value;
}

}  // namespace qs
