// SPDX-License-Identifier: MIT
//
// The Gaussians of one block that preprocess has not dropped, packed to the front of every array.
// It fits into the first-level cache. The steps are:
//   project -> list_tiles (drops Gaussians without tiles) -> color -> FastVisible::records
#pragma once

#include "raster/cpu/fast/blocks.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cpu::fast {

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
/// have a tile in any mode.
void project(const View<float>& view, const FootprintRules& rules, TileGrid grid,
             const Block& block, Survivors& out);

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
