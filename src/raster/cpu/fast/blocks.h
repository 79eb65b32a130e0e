// SPDX-License-Identifier: MIT
//
// The scene as the fast pipeline reads it: blocks of Gaussians, one plane per value, so that a
// vector holds the same value of neighbouring Gaussians. Made once per upload, in file order; the
// last block is filled up with Gaussians that no view shows.
#pragma once

#include "raster/scene/activated_cloud.h"

namespace qs::cpu::fast {

/// Gaussians in a block, a multiple of every vector's length.
inline constexpr std::size_t kBlock = 256;

struct alignas(64) Block {
  float x[kBlock], y[kBlock], z[kBlock];  ///< world; NaN where there is no Gaussian
  float xx[kBlock], xy[kBlock], xz[kBlock], yy[kBlock], yz[kBlock], zz[kBlock];  ///< covariance
  float log2_255_opacity[kBlock];
};

/// Gaussians whose coefficients of the colour lie together.
inline constexpr std::size_t kGroup = 16;

/// Per group of Gaussians, coefficient and channel: the values of its members side by side.
struct Harmonics {
  int degree = 0;
  Array<float> values;

  /// Values of a group.
  std::size_t group_size() const {
    return static_cast<std::size_t>(3 * sh_coefficient_count(degree)) * kGroup;
  }
};

Array<Block> make_blocks(const ActivatedCloud& active, ThreadPool& pool);
Harmonics make_harmonics(const GaussianCloud& cloud, ThreadPool& pool);

}  // namespace qs::cpu::fast
