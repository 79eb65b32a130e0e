// SPDX-License-Identifier: MIT
//
// The Gaussians of one block that preprocess has not dropped, packed to the front of every array.
// It fits into the first-level cache. The steps are:
//   project -> list_tiles (drops Gaussians without tiles) -> color -> FastVisible::records
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/frustum.h"
#include "raster/kernel/tile_grid.h"
#include "raster/scene/gaussian_cloud.h"
#include "raster/scene/gaussian_set.h"

namespace qs::cpu::fast {

// The scene in the layout of the fast pipeline: blocks in spatial order with one array per value,
// so that a vector register holds the same value of neighbouring Gaussians, and bounds that let a
// view skip whole blocks. Made once per upload. The last block is padded with Gaussians that no
// view shows.

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
  /// A bit per Gaussian in the order of the blocks, see Renderer::set_drawn(); empty: all.
  Array<std::uint64_t> drawn = {};
  static constexpr std::size_t kDrawnWords = kBlock / 64;  ///< of a block

  void set_drawn(const GaussianSet& set, ThreadPool& pool);

  /// By index in the cloud: the place in the order of the blocks. Made by the first update().
  Array<std::uint32_t> places = {};

  /// Reads Gaussians of `cloud` again. False if their coefficients need floats in place of halves;
  /// then the scene must be made again.
  bool update(const GaussianCloud& cloud, std::span<const std::uint32_t> changed, ThreadPool& pool);

  /// Words of `drawn` for block `b`, or null.
  const std::uint64_t* drawn_in(std::size_t b) const {
    return drawn.empty() ? nullptr : &drawn[b * kDrawnWords];
  }
  /// False only if no mode lists a tile of a drawn Gaussian of block `b`.
  bool shows(const Frustum& frustum, std::size_t b) const {
    const std::uint64_t* const bits = drawn_in(b);
    if (bits != nullptr && (bits[0] | bits[1] | bits[2] | bits[3]) == 0) return false;
    return !frustum.misses(bounds[b]);
  }
};

SceneBlocks make_scene(const GaussianCloud& cloud, ThreadPool& pool);

struct alignas(64) Survivors {
  /// Stores write whole vectors, so the arrays have room for one more.
  static constexpr std::size_t kRoom = kBlock + 16;

  std::uint32_t lane[kRoom];  ///< position in the block, ascending
  float mean_x[kRoom], mean_y[kRoom];
  float xx[kRoom], xy[kRoom], yy[kRoom];  ///< covariance, see Footprint
  float conic_a[kRoom], conic_b[kRoom], conic_c[kRoom];
  float determinant[kRoom], gamma[kRoom];
  float depth[kRoom], log2_opacity[kRoom];
  std::size_t count = 0;  ///< the last member, so that all arrays are aligned

  Footprint footprint(std::size_t k) const {
    return {{mean_x[k], mean_y[k]},
            {xx[k], xy[k], yy[k]},
            {conic_a[k], conic_b[k], conic_c[k]},
            determinant[k],
            gamma[k]};
  }
};

/// project() of kernel/footprint.h; a test compares the results bit for bit. Fills `out` with the
/// Gaussians of `block` that have a footprint, except Gaussians too far outside of the image to
/// have a tile in any mode, and except Gaussians without their bit in `drawn`: null, or the words
/// of SceneBlocks::drawn.
void project(const View<float>& view, const FootprintRules& rules, TileGrid grid,
             const Block& block, const std::uint64_t* drawn, Survivors& out);

/// Per Gaussian of a block.
struct alignas(64) Colors {
  float red[kBlock], green[kBlock], blue[kBlock];
};

/// The inputs of a frame's colours, besides the Gaussians' positions.
struct ColorInput {
  const Harmonics& sh;
  int degree;               ///< evaluated, at most sh.degree
  glm::vec3 view_position;  ///< the camera, world
};

/// sh_color() of kernel/sh.h: fills the colours of the survivors of block `index`, and of other
/// members of their groups.
void color(const ColorInput& in, const Block& block, std::size_t index, const Survivors& survivors,
           Colors& colors);

}  // namespace qs::cpu::fast
