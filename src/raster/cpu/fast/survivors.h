// SPDX-License-Identifier: MIT
//
// The Gaussians of one block that preprocess has not dropped, packed to the front of every array.
// It fits into the first-level cache. The steps are:
//   project -> list_tiles (drops Gaussians without tiles) -> color -> FastVisible::records
#pragma once

#include "raster/cpu/fast/blocks.h"
#include "raster/kernel/footprint.h"

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

}  // namespace qs::cpu::fast
