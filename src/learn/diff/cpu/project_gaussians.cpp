// SPDX-License-Identifier: MIT
#include "learn/diff/cpu/project_gaussians.h"

#include "raster/cpu/common/pixel_bound.h"
#include "raster/kernel/cull/modes.h"

namespace qs::cpu::diff {

CountTiles tile_counter(CullMode mode) {
  return with_culler(mode, []<class P>(P) -> CountTiles {
    return
        [](const Footprint& footprint, TileGrid grid) { return count_tiles<P>(footprint, grid); };
  });
}

PixelArea PixelArea::of(const Footprint& footprint) {
  // The slack covers the rounding of the falloff, as in pipeline `classic`.
  const PixelBound bound = PixelBound::of(footprint);
  return {footprint.mean_px,
          bound.half,
          bound.slope,
          footprint.gamma > 0 ? bound.threshold / kLog2OfFalloff : 0,
          1 / footprint.covariance.yy,
          1 / footprint.conic.x};
}

}  // namespace qs::cpu::diff
