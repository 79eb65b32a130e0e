// SPDX-License-Identifier: MIT
//
// What compressed formats have in common: opacity in a byte and quaternions without their largest
// component.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <glm/gtc/quaternion.hpp>

namespace qs {

/// Logit of an opacity stored as 0..255 for 0..1; 0 and 255 give -inf and +inf.
inline float logit_of_byte(std::uint8_t byte) {
  return static_cast<float>(std::log(byte / (255.0 - byte)));
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

inline glm::quat make_quat(double w, double x, double y, double z) {
  return {static_cast<float>(w), static_cast<float>(x), static_cast<float>(y),
          static_cast<float>(z)};
}

}  // namespace qs
