// SPDX-License-Identifier: MIT
#include "raster/cpu/stages/project_gaussians.h"

#include "raster/kernel/cull/modes.h"

namespace qs::cpu::stages {
namespace {

template <class P>
unsigned tiles_of(const Footprint& footprint, TileGrid grid) {
  return count_tiles<P>(footprint, grid);
}

}  // namespace

CountTiles tile_counter(CullMode mode) {
  return with_culler(mode, []<class P>(P) -> CountTiles { return tiles_of<P>; });
}

}  // namespace qs::cpu::stages
