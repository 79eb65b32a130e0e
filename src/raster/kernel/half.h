// SPDX-License-Identifier: MIT
//
// Half precision (IEEE binary16) without special hardware. float_of_half() and to_half() are for
// finite values; the other two know infinities and NaN.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "raster/kernel/hd.h"

namespace qs {

// A half has 5 bits for the exponent and a bias of 15, a float 8 and 127. Shifting a half's bits
// into a float divides its value by 2^112; that is exact for subnormal halves too.
inline constexpr int kHalfShift = 13;

QS_HD float float_of_half(std::uint16_t half) {
  constexpr float kScale = 0x1p112f;
  const std::uint32_t bits = (half & 0x8000u) << 16 | static_cast<std::uint32_t>(half & 0x7fffu)
                                                          << kHalfShift;
  return std::bit_cast<float>(bits) * kScale;
}

/// True if a half equals `value`; it is then stored in `half`.
QS_HD bool to_half(float value, std::uint16_t& half) {
  constexpr float kScale = 0x1p-112f, kLargest = 65504;
  if (!(value >= -kLargest && value <= kLargest)) return false;
  const auto bits = std::bit_cast<std::uint32_t>(value * kScale);
  half = static_cast<std::uint16_t>((bits >> 16 & 0x8000u) | (bits >> kHalfShift & 0x7fffu));
  return float_of_half(half) == value;
}

/// The nearest half of a finite value; beyond the largest half, that one.
QS_HD std::uint16_t nearest_half(float value) {
  constexpr float kScale = 0x1p-112f, kLargest = 65504;
  const float inside = value < -kLargest ? -kLargest : value > kLargest ? kLargest : value;
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(inside * kScale) + 0x0fffu +
                             (std::bit_cast<std::uint32_t>(inside * kScale) >> kHalfShift & 1u);
  return static_cast<std::uint16_t>((bits >> 16 & 0x8000u) | (bits >> kHalfShift & 0x7fffu));
}

/// As float_of_half(), also for infinities and NaN.
QS_HD float float_of_any_half(std::uint16_t half) {
  const float value = float_of_half(half);
  if ((half & 0x7c00u) != 0x7c00u) return value;
  if ((half & 0x3ffu) != 0) return NAN;
  return value < 0 ? -INFINITY : INFINITY;
}

/// The half nearest to `value`; of two that are equally near, the half whose last bit is 0. Values
/// from 65520 on give infinity.
QS_HD std::uint16_t round_to_half(float value) {
  auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 16 & 0x8000u;
  bits &= 0x7fffffffu;
  if (bits > 0x7f800000u) return static_cast<std::uint16_t>(sign | 0x7e00u);   // NaN
  if (bits >= 0x477ff000u) return static_cast<std::uint16_t>(sign | 0x7c00u);  // 65520 on
  if (bits < 0x38800000u) {  // below 2^-14, where halves are multiples of 2^-24, as floats at 1/2
    bits = std::bit_cast<std::uint32_t>(std::bit_cast<float>(bits) + 0.5f);
    return static_cast<std::uint16_t>(sign | (bits - 0x3f000000u));
  }
  bits += 0xfffu + (bits >> kHalfShift & 1u);
  return static_cast<std::uint16_t>(sign | ((bits - (112u << 23)) >> kHalfShift));
}

}  // namespace qs
