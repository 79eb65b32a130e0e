// SPDX-License-Identifier: MIT
//
// The colour field of Compact-3DGS (Lee et al., Compact 3D Gaussian Representation for Radiance
// Field, 2024): where a position lies in a multiresolution hash grid (Mueller et al., Instant
// Neural Graphics Primitives, 2022), and how a direction enters the network. Layout and signs are
// as in tiny-cuda-nn, which trained the published models.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/constants.h"
#include "raster/kernel/hd.h"

namespace qs {

inline constexpr int kGridFeatures = 2;       ///< values per entry of the hash grid
inline constexpr int kDirectionFeatures = 9;  ///< SH of degree 2

/// One level of a hash grid. Its entries are numbered from 0.
struct GridLevel {
  float scale = 0;               ///< cells per unit of length
  std::uint32_t resolution = 0;  ///< vertices along an axis
  std::uint32_t entries = 0;     ///< at most 2^31
  std::uint64_t first = 0;       ///< entries of all levels before
  bool is_dense = false;         ///< every vertex has its own entry; else vertices are hashed
};

/// Maps all of space into [0, 1]^3: the unit ball into the ball of radius 1/4, the rest around it.
template <class Real>
QS_HD glm::vec<3, Real> contract(const glm::vec<3, Real>& mean) {
  const Real length = std::sqrt(mean.x * mean.x + mean.y * mean.y + mean.z * mean.z);
  const Real factor = length <= 1 ? Real(1) : (2 - 1 / length) / length;
  return mean * (factor / 4) + Real(0.5);
}

/// The entry of the vertex (x, y, z) in its level.
QS_HD std::uint32_t grid_entry(const GridLevel& level, std::uint32_t x, std::uint32_t y,
                               std::uint32_t z) {
  const std::uint32_t index = level.is_dense ? x + level.resolution * (y + level.resolution * z)
                                             : x ^ (2654435761u * y) ^ (805459861u * z);
  return index % level.entries;
}

/// The cell of a level that contains a position, 0..1 inside of the grid. Its eight corners are
/// numbered: bit k of a corner is set if it is the upper one along axis k.
template <class Real>
struct GridCell {
  std::uint32_t vertex[3];  ///< corner 0
  glm::vec<3, Real> part;   ///< part of the position between corner 0 and corner 7, 0..1

  static QS_HD GridCell of(const GridLevel& level, const glm::vec<3, Real>& position) {
    const glm::vec<3, Real> place = static_cast<Real>(level.scale) * position + Real(0.5);
    const glm::vec<3, Real> cell = glm::floor(place);
    return {{static_cast<std::uint32_t>(cell.x), static_cast<std::uint32_t>(cell.y),
             static_cast<std::uint32_t>(cell.z)},
            place - cell};
  }

  QS_HD bool is(const GridCell& other) const {
    return vertex[0] == other.vertex[0] && vertex[1] == other.vertex[1] &&
           vertex[2] == other.vertex[2];
  }
  /// Counts from the first entry of the first level.
  QS_HD std::size_t entry(const GridLevel& level, unsigned corner) const {
    return static_cast<std::size_t>(level.first + grid_entry(level, vertex[0] + (corner & 1),
                                                             vertex[1] + (corner >> 1 & 1),
                                                             vertex[2] + (corner >> 2 & 1)));
  }
  /// The weights of all corners add up to 1.
  QS_HD Real weight(unsigned corner) const {
    Real weight = 1;
    for (int axis = 0; axis < 3; ++axis)
      weight *= (corner >> axis & 1) != 0 ? part[axis] : 1 - part[axis];
    return weight;
  }
};

/// Calls visit(entry, weight) for the corners of the cell that contains `position`.
template <class Real, class Visit>
QS_HD void for_each_vertex(const GridLevel& level, const glm::vec<3, Real>& position,
                           const Visit& visit) {
  const auto cell = GridCell<Real>::of(level, position);
  for (unsigned corner = 0; corner < 8; ++corner)
    visit(cell.entry(level, corner), cell.weight(corner));
}

/// The kDirectionFeatures inputs of the network for the unit vector `d` from the camera to the
/// Gaussian. The published models pass `d` where the encoding expects values of 0..1, so it maps
/// them by 2 d - 1: the SH are evaluated at vectors that are not unit.
template <class Real>
QS_HD void encode_direction(const glm::vec<3, Real>& d, Real* features) {
  const Real x = 2 * d.x - 1, y = 2 * d.y - 1, z = 2 * d.z - 1;
  features[0] = Real(kSh0);
  features[1] = -Real(kSh1) * y;
  features[2] = Real(kSh1) * z;
  features[3] = -Real(kSh1) * x;
  features[4] = Real(kSh2A) * x * y;
  features[5] = -Real(kSh2A) * y * z;
  features[6] = Real(kSh2B) * (3 * z * z - 1);
  features[7] = -Real(kSh2A) * x * z;
  features[8] = Real(kSh2C) * (x * x - y * y);
}

/// A channel of the colour, as pixels read it, from the network's output.
template <class Real>
QS_HD Real color_of_output(Real output) {
  return glm::max(Real(kSh0) * output + Real(0.5), Real(0));
}

// The derivatives by the network's weights are sums over Gaussians. Runs of kFieldRun neighbours
// are dealt to kFieldBlocks blocks in turn. A block sums its Gaussians in ascending order, and then
// the blocks are summed in their order. So the result does not depend on threads, nor on Gaussians
// without a gradient.
inline constexpr std::uint32_t kFieldBlocks = 256, kFieldRun = 32;

/// Positions of a block of `count` Gaussians.
QS_HD std::size_t field_block_size(std::size_t count) {
  const std::size_t runs = (count + kFieldRun - 1) / kFieldRun;
  return (runs + kFieldBlocks - 1) / kFieldBlocks * kFieldRun;
}

/// The Gaussian at a position of a block. It may be beyond the last Gaussian.
QS_HD std::size_t field_gaussian(std::size_t block, std::size_t position) {
  return (position / kFieldRun * kFieldBlocks + block) * kFieldRun + position % kFieldRun;
}

}  // namespace qs
