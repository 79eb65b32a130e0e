// SPDX-License-Identifier: MIT
//
// Encodings that compressed formats share: opacity in one byte, and quaternions without their
// largest component.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <glm/gtc/quaternion.hpp>

#include "base/rounding.h"

namespace qs {

/// Logit of an opacity stored as 0..`highest` for 0..1: 0 and all from `highest` on give -inf and
/// +inf.
inline float logit_of_byte(std::uint8_t byte, double highest = 255) {
  return static_cast<float>(std::log(byte / std::max(highest - byte, 0.0)));
}

/// A unit quaternion without its largest component.
struct SmallestThree {
  std::uint32_t dropped = 0;       ///< index of the largest component in the argument
  std::array<double, 3> others{};  ///< in the argument's order, negated if the largest is negative
};

inline SmallestThree drop_largest(const std::array<double, 4>& q) {
  SmallestThree result;
  for (std::uint32_t i = 1; i < 4; ++i)
    if (std::abs(q[i]) > std::abs(q[result.dropped])) result.dropped = i;
  const double sign = q[result.dropped] < 0 ? -1 : 1;
  for (std::size_t i = 0, next = 0; i < 4; ++i)
    if (i != result.dropped) result.others[next++] = sign * q[i];
  return result;
}

/// Inverse of drop_largest(): the four components of a unit quaternion whose largest component, at
/// index `dropped`, is positive and was left out.
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

inline glm::quat make_quat(double w, double x, double y, double z) {
  return {static_cast<float>(w), static_cast<float>(x), static_cast<float>(y),
          static_cast<float>(z)};
}

}  // namespace qs
