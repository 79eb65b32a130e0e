// SPDX-License-Identifier: MIT
//
// The reduced resolution of a slow backend while the camera moves.
#pragma once

#include <algorithm>
#include <cmath>

namespace qs {

inline constexpr double kMovingFrameMs = 40;
inline constexpr int kMostDivisor = 8;

/// The smallest n, 1 to kMostDivisor, for which a frame of width / n x height / n is expected to
/// take at most kMovingFrameMs.
inline int resolution_divisor(double ms_per_megapixel, int width, int height) {
  const double ms = ms_per_megapixel * 1e-6 * width * height;
  const double divisor = std::ceil(std::sqrt(std::max(0.0, ms) / kMovingFrameMs));
  return static_cast<int>(std::clamp(divisor, 1.0, static_cast<double>(kMostDivisor)));
}

}  // namespace qs
