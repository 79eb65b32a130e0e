// SPDX-License-Identifier: MIT
//
// Comparisons of DepthMaps with the bounds that docs/commands.md states.
#pragma once

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "raster/api/renderer.h"

namespace qs::test {

inline bool equal(const DepthMaps& a, const DepthMaps& b) {
  return a.alpha == b.alpha && a.expected == b.expected && a.median == b.median;
}

/// Share of the pixels, 0..1, at which two maps differ by more than `tolerance` times the larger of
/// 1 and the value.
inline double share_beyond(const std::vector<float>& a, const std::vector<float>& b,
                           double tolerance) {
  EXPECT_EQ(a.size(), b.size());
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const double x = static_cast<double>(a[i]), y = static_cast<double>(b[i]);
    if (!(std::abs(x - y) <= tolerance * std::max(1.0, std::abs(y)))) ++beyond;
  }
  return static_cast<double>(beyond) / static_cast<double>(std::max<std::size_t>(1, a.size()));
}

/// The bound between backends and against mode reference. One pixel in a thousand may exceed it,
/// because rounding decides: alpha at 1/255, the transmittance at which a pixel stops, and for the
/// median a transmittance of 1/2.
inline void expect_same_depth(const DepthMaps& maps, const DepthMaps& expected) {
  const double few = std::max(1e-3, 1 / static_cast<double>(expected.alpha.size()));
  EXPECT_LE(share_beyond(maps.alpha, expected.alpha, 1e-4), few);
  EXPECT_LE(share_beyond(maps.expected, expected.expected, 1e-4), few);
  EXPECT_LE(share_beyond(maps.median, expected.median, 1e-4), few);
  EXPECT_EQ(share_beyond(maps.alpha, expected.alpha, 0.02), 0);
}

}  // namespace qs::test
