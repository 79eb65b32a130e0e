// SPDX-License-Identifier: MIT
//
// The walk of mode `quadbox` for a whole block, by vectors: its conditions are unpredictable as
// branches.
#pragma once

#include "raster/cpu/fast/survivors.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cpu::fast {

/// The walks of a block's survivors and the spans of their first lines, one array per value.
struct alignas(64) QuadBoxWalks {
  static constexpr int kLines = 4;

  std::int32_t by_rows[kBlock];                        ///< 0 or not
  std::int32_t lines_begin[kBlock], lines_end[kBlock];
  std::int32_t begin[kLines][kBlock], end[kLines][kBlock];

  /// Equals QuadBox::walk() of kernel/cull/quad_box.h bit for bit.
  void compute(TileGrid grid, const Survivors& survivors);

  bool has_all_spans(std::size_t k) const { return lines_end[k] - lines_begin[k] <= kLines; }
};

}  // namespace qs::cpu::fast
