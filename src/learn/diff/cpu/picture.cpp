// SPDX-License-Identifier: MIT
#include "learn/diff/cpu/picture.h"

#include "raster/cpu/common/pixel_bound.h"

namespace qs::cpu::diff {

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
