// SPDX-License-Identifier: MIT
//
// Gaussians as the fast pipeline reads them: in blocks, one plane per value, so that a vector holds
// the same value of neighbouring Gaussians. Made once per upload, in any order; the last block is
// filled up with Gaussians that no view shows.
#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "raster/scene/activated_cloud.h"

namespace qs::cpu::fast {

/// Gaussians in a block, a multiple of every vector's length.
inline constexpr std::size_t kBlock = 256;

struct alignas(64) Block {
  std::uint32_t gaussian[kBlock];         ///< index in the cloud
  float x[kBlock], y[kBlock], z[kBlock];  ///< world; NaN where there is no Gaussian
  float xx[kBlock], xy[kBlock], xz[kBlock], yy[kBlock], yz[kBlock], zz[kBlock];  ///< covariance
  float log2_255_opacity[kBlock];
};

/// Gaussians whose coefficients of the colour lie together.
inline constexpr std::size_t kGroup = 16;

/// Coefficients of the colour: per group, coefficient and channel the values of the group's members
/// side by side. Those of degree 1 and more are kept in half precision where that loses nothing,
/// which holds for every scene out of an .spz file: they are most of what a frame reads.
struct Harmonics {
  int degree = 0;
  Array<float> base;            ///< degree 0: 3 per Gaussian
  Array<float> rest;            ///< the others; empty where `halves` has them
  Array<std::uint16_t> halves;  ///< the others as IEEE binary16

  /// Values of degree 1 and more of a group.
  std::size_t rest_size() const {
    return static_cast<std::size_t>(3 * (sh_coefficient_count(degree) - 1)) * kGroup;
  }
};

/// `order` has the cloud's indices in the order in which its Gaussians are to lie.
Array<Block> make_blocks(const ActivatedCloud& active, std::span<const std::uint32_t> order,
                         ThreadPool& pool);
Harmonics make_harmonics(const GaussianCloud& cloud, std::span<const std::uint32_t> order,
                         ThreadPool& pool);

struct Half {
  std::uint16_t bits;  ///< IEEE binary16, when exact
  bool exact;          ///< whether the value is 0 or a normal number there
};

/// Without a branch, for loops that become vectors.
inline Half to_half(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 31 << 15, magnitude = bits & 0x7fffffff;
  constexpr std::uint32_t kSmallest = (127u - 14) << 23, kBehindLargest = (127u + 16) << 23;
  const bool zero = magnitude == 0;
  const bool normal = static_cast<bool>((magnitude >= kSmallest) & (magnitude < kBehindLargest) &
                                        ((bits & 0x1fff) == 0));
  const std::uint32_t half = zero ? 0 : (magnitude - kSmallest + (1u << 23)) >> 13;
  return {static_cast<std::uint16_t>(sign | half), zero || normal};
}

}  // namespace qs::cpu::fast
