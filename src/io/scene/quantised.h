// SPDX-License-Identifier: MIT
//
// What compressed formats have in common: opacity in a byte, half floats and quaternions without
// their largest component; from numbers to floats and back.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <glm/gtc/quaternion.hpp>

namespace qs {

/// Logit of an opacity stored as 0..255 for 0..1; 0 and 255 give -inf and +inf.
inline float logit_of_byte(std::uint8_t byte) {
  return static_cast<float>(std::log(byte / (255.0 - byte)));
}

/// `value` as a whole number from 0 to `max`, rounded; NaN gives 0.
inline std::uint32_t whole(double value, std::uint32_t max) {
  return value > 0 ? static_cast<std::uint32_t>(std::min(value + 0.5, static_cast<double>(max)))
                   : 0;
}

/// The opacity of a logit, 0..1.
inline double opacity_of_logit(float logit) {
  return 1 / (1 + std::exp(-static_cast<double>(logit)));
}

/// A unit quaternion without its largest component.
struct SmallestThree {
  std::uint32_t dropped = 0;       ///< number of the largest, in the order of the argument
  std::array<double, 3> others{};  ///< ascending, with signs as if the largest were positive
};

inline SmallestThree drop_largest(const std::array<double, 4>& q) {
  SmallestThree result;
  for (std::uint32_t i = 1; i < 4; ++i) {
    if (std::abs(q[i]) > std::abs(q[result.dropped])) result.dropped = i;
  }
  const double sign = q[result.dropped] < 0 ? -1 : 1;
  for (std::size_t i = 0, next = 0; i < 4; ++i) {
    if (i != result.dropped) result.others[next++] = sign * q[i];
  }
  return result;
}

/// The four components, in the format's order, of a unit quaternion whose largest one, number
/// `dropped`, was left out; the other three are in ascending order. It counts as positive.
inline std::array<double, 4> restore_largest(std::array<double, 3> others, std::size_t dropped) {
  std::array<double, 4> q{};
  double square = 0;
  for (std::size_t i = 0, next = 0; i < 4; ++i) {
    if (i == dropped) continue;
    q[i] = others[next++];
    square += q[i] * q[i];
  }
  q[dropped] = std::sqrt(std::max(0.0, 1 - square));  // damaged files have more than 1
  return q;
}

/// The value of an IEEE half float.
inline float half_to_float(std::uint16_t half) {
  const int exponent = (half >> 10) & 31, mantissa = half & 1023;
  const float sign = (half & 0x8000) != 0 ? -1.0f : 1.0f;
  if (exponent == 31) {
    return mantissa == 0 ? sign * std::numeric_limits<float>::infinity()
                         : std::numeric_limits<float>::quiet_NaN();
  }
  if (exponent == 0) return sign * std::ldexp(static_cast<float>(mantissa), -24);
  return sign * std::ldexp(static_cast<float>(mantissa + 1024), exponent - 25);
}

inline glm::quat make_quat(double w, double x, double y, double z) {
  return {static_cast<float>(w), static_cast<float>(x), static_cast<float>(y),
          static_cast<float>(z)};
}

}  // namespace qs
