// SPDX-License-Identifier: MIT
#include "learn/diff/cpu/project_gaussians.h"

#include "raster/kernel/cull/modes.h"

namespace qs::cpu::diff {
namespace {

template <class P>
unsigned tiles_of(const Footprint& footprint, TileGrid grid) {
  return count_tiles<P>(footprint, grid);
}

}  // namespace

CountTiles tile_counter(CullMode mode) {
  return with_culler(mode, []<class P>(P) -> CountTiles { return tiles_of<P>; });
}

}  // namespace qs::cpu::diff
