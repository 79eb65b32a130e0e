// SPDX-License-Identifier: MIT
//
// A node of a tree with levels of detail, as the builder makes it and a .rad file stores it. Beside
// the Gaussian that every viewer draws it has facts for quadsplat: the gain and the estimated error
// at kLodFootprints footprints. A *footprint* h is the side of a pixel in world units at the node,
// depth / focal length.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

namespace qs {

/// A merged node in a list of the numbers of leaves in their sources.
inline constexpr std::uint32_t kNoNumber = 0xffffffff;

inline constexpr std::size_t kLodFootprints = 8;
/// Each footprint is so many times the footprint before it.
inline constexpr float kLodFootprintRatio = 4;
/// The squares of neighbouring footprints differ by this number of steps.
inline constexpr int kLodStepsOfFootprint = 16;

/// A value per footprint, in steps of a quarter of a power of two.
using LodSteps = std::array<std::uint8_t, kLodFootprints>;
inline constexpr std::uint8_t kLodMostSteps = 255;

/// Footprint `k`; 0 is `smallest`.
inline float lod_footprint(float smallest, std::size_t k) {
  return smallest * std::pow(kLodFootprintRatio, static_cast<float>(k));
}

/// A value, colour^2 times world units^2, in steps; 0 for values up to 2^-28 of the square of the
/// smallest footprint. lod_value() is the inverse.
inline std::uint8_t lod_step(float value, float smallest) {
  const float unit = smallest * smallest * 0x1p-28f;
  if (!(value > unit)) return 0;
  return static_cast<std::uint8_t>(std::lround(std::min(4 * std::log2(value / unit), 255.0f)));
}
inline float lod_value(std::uint8_t step, float smallest) {
  return step == 0 ? 0 : smallest * smallest * std::exp2(static_cast<float>(step) / 4 - 28);
}

/// The value, in steps, at a place among the footprints, 0 to kLodFootprints - 1: interpolated.
inline float lod_step_at(const LodSteps& steps, float place) {
  const auto below = std::min(static_cast<std::size_t>(place), kLodFootprints - 2);
  const float part = place - static_cast<float>(below);
  return static_cast<float>(steps[below]) * (1 - part) +
         static_cast<float>(steps[below + 1]) * part;
}

/// A node without its Gaussian.
struct LodFacts {
  std::uint32_t parent = 0, first_child = 0;
  std::uint16_t child_count = 0;  ///< 0: a leaf
  // Leaves have 0 in the rest.
  /// Error that the node adds per Gaussian that it saves, in cuts at this footprint. Parents gain
  /// at least as much as their children, and gain / h^2 does not grow with h.
  LodSteps gains{};
  LodSteps errors{};    ///< estimated: against all of its leaves
  float layers = 0;     ///< mass / area; above 1 the scales have grown, see learn/lod/merging.h
  float opacities = 0;  ///< sum over its leaves
  /// The ball around its centre has the centres of its leaves, and 3 standard deviations of its
  /// Gaussian.
  float radius = 0;
};

struct LodNode : LodFacts {
  glm::vec3 center{0}, scales{0};  ///< world units; standard deviations
  glm::quat rotation{1, 0, 0, 0};
  float alpha = 0;  ///< 0..1
};

}  // namespace qs
