// SPDX-License-Identifier: MIT
//
// A grid of cubes over a cloud, numbered so that neighbours along x follow each other. The cells
// are a multiple of the median Gaussian long.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// ln of the longest standard deviation; NaN if a value is NaN.
float log_size(const GaussianCloud& cloud, std::size_t i);

/// value_of(i) of the Gaussians, without values that are not finite.
template <class ValueOf>
std::vector<float> finite_values(std::span<const std::uint32_t> of, const ValueOf& value_of) {
  std::vector<float> values;
  values.reserve(of.size());
  for (const std::uint32_t i : of)
    if (const float value = value_of(i); std::isfinite(value)) values.push_back(value);
  return values;
}

struct CellGrid {
  glm::dvec3 middle{0.0};
  float median = 0;  ///< log_size() of the median Gaussian
  double cell = 0;   ///< length, > 0

  static constexpr float kCellSigmas = 4;  ///< standard deviations of the median Gaussian
  static constexpr int kFieldBits = 21, kFinerBits = 2;

  /// The grid around the medians of the centres of these Gaussians. Empty if no size is finite.
  static std::optional<CellGrid> around(const GaussianCloud& cloud,
                                        std::span<const std::uint32_t> of);

  /// The cell of a position; empty if that is not finite. Places far out are in the border's cells.
  std::optional<std::uint64_t> key(glm::vec3 position) const;

  /// Keys number cells by z, then y, then x. Coordinates are stored from 1 on, so that every cell
  /// has all its neighbours.
  static constexpr std::uint64_t key_of(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
    return (z + 1) << (2 * kFieldBits) | (y + 1) << kFieldBits | (x + 1);
  }

  /// The cell of a grid with cells four times as long.
  static constexpr std::uint64_t coarser(std::uint64_t key) {
    const auto field = [key](int n) {
      constexpr std::uint64_t kField = (std::uint64_t{1} << kFieldBits) - 1;
      return ((key >> (n * kFieldBits)) & kField) - 1;
    };
    return key_of(field(0) >> kFinerBits, field(1) >> kFinerBits, field(2) >> kFinerBits);
  }

  /// The difference of keys of a cell and the cell by so many cells away. Wraps around for negative
  /// steps, as unsigned numbers do.
  static constexpr std::uint64_t step(int x, int y, int z) {
    return (static_cast<std::uint64_t>(z) << (2 * kFieldBits)) +
           (static_cast<std::uint64_t>(y) << kFieldBits) + static_cast<std::uint64_t>(x);
  }
};

}  // namespace qs
