// SPDX-License-Identifier: MIT
#include "raster/cpu/common/pixel_bound.h"

#include "raster/kernel/constants.h"
#include "raster/kernel/cull/culler.h"

namespace qs::cpu {

PixelBound PixelBound::of(const Footprint& footprint) {
  if (!(footprint.gamma > 0.0f)) return {{0, 0}, 0, 0};
  return {extents(footprint).max + 1.0f, footprint.covariance.xy / footprint.covariance.yy,
          kLog2OfFalloff * footprint.gamma - kLog2Slack};
}

}  // namespace qs::cpu
