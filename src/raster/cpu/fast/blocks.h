// SPDX-License-Identifier: MIT
//
// The scene in the layout of the fast pipeline: blocks in spatial order with one array per value,
// so that a vector register holds the same value of neighbouring Gaussians, and bounds that let a
// view skip whole blocks. Made once per upload. The last block is padded with Gaussians that no
// view shows.
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.h"
#include "raster/kernel/frustum.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::cpu::fast {

/// Gaussians in a block, a multiple of every vector length.
inline constexpr std::size_t kBlock = 256;

struct alignas(64) Block {
  std::uint32_t gaussian[kBlock];         ///< index in the cloud
  float x[kBlock], y[kBlock], z[kBlock];  ///< world; NaN in the padding
  float xx[kBlock], xy[kBlock], xz[kBlock], yy[kBlock], yz[kBlock], zz[kBlock];  ///< covariance
  float log2_255_opacity[kBlock];
};

/// Number of Gaussians whose colour coefficients are interleaved.
inline constexpr std::size_t kGroup = 16;

/// Colour coefficients, indexed [group][coefficient][channel][member]. The coefficients of degree
/// >= 1 are most of the memory that a frame reads, so they are stored in half precision if that is
/// exact for the whole scene, as it is for scenes from .spz files.
struct Harmonics {
  int degree = 0;
  Array<float> base;            ///< degree 0
  Array<float> rest;            ///< degree >= 1; empty if `halves` has them
  Array<std::uint16_t> halves;  ///< degree >= 1 as IEEE binary16; empty if `rest` has them

  /// Number of values of degree >= 1 in a group.
  std::size_t rest_size() const {
    return static_cast<std::size_t>(3 * (sh_coefficient_count(degree) - 1)) * kGroup;
  }
};

/// Converts `count` values, a multiple of 16, to halves. True if the halves equal all of them
/// (zeros may lose their sign); otherwise the halves must not be used. In color.cpp, which reads
/// halves.
bool to_halves(const float* values, std::size_t count, std::uint16_t* halves);

/// `order`: the cloud's indices in the order of the blocks.
Harmonics make_harmonics(const GaussianCloud& cloud, std::span<const std::uint32_t> order,
                         ThreadPool& pool);

struct SceneBlocks {
  Array<Block> blocks;
  Array<BlockBounds> bounds;  ///< per block
  Harmonics harmonics;
};

SceneBlocks make_scene(const GaussianCloud& cloud, ThreadPool& pool);

}  // namespace qs::cpu::fast
