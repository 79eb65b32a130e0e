// SPDX-License-Identifier: MIT
//
// The walks of the culling modes for a whole block, by vectors: their conditions are unpredictable
// as branches. All modes have vector code here, except quadbox-naive, whose loops are not a walk.
// So no mode is faster only because of its implementation. A new mode works without vector code,
// more slowly.
#pragma once

#include "raster/cpu/fast/survivors.h"
#include "raster/kernel/cull/mode.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cpu::fast {

/// The walks of a block's survivors and the spans of their first lines, one array per value.
struct alignas(64) Walks {
  static constexpr int kLines = 4;

  std::int32_t by_rows[kBlock];  ///< 0 or not
  std::int32_t lines_begin[kBlock], lines_end[kBlock];
  std::int32_t begin[kLines][kBlock], end[kLines][kBlock];

  /// Equals the mode's walk() in kernel/cull/ bit for bit. False if the mode has no vectors.
  bool compute(CullMode mode, TileGrid grid, const Survivors& survivors);

  bool has_all_spans(std::size_t k) const { return lines_end[k] - lines_begin[k] <= kLines; }
};

}  // namespace qs::cpu::fast
