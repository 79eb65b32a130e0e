// SPDX-License-Identifier: MIT
//
// Stage 1: finds the Gaussians that the view shows.
#pragma once

#include <algorithm>

#include "raster/cpu/common/pixel_bound.h"
#include "raster/cpu/common/visible.h"
#include "raster/kernel/blend.h"
#include "raster/scene/activated_cloud.h"

namespace qs::cpu {

struct BoundedSplat {
  Splat splat;
  PixelBound bound;
};

/// True if one of `count` pixels side by side can have alpha >= 1/255. (dx, dy) is the first pixel
/// minus the mean.
inline bool touches(const BoundedSplat& bounded, float dx, float dy, int count) {
  const glm::vec3& conic = bounded.splat.log2_conic;
  const float x = std::clamp(bounded.bound.slope * dy, dx, dx + static_cast<float>(count - 1));
  const float xx = conic.x * x * x, yy = conic.z * dy * dy;
  const float rounding = -kFalloffRounding * (xx + yy);
  return xx + yy + conic.y * x * dy + rounding >= bounded.bound.threshold;
}

struct Visible : VisibleSlots {
  Array<BoundedSplat> splats;  ///< per slot
};

/// Projects, culls by the frame's mode and evaluates colours. A Gaussian without tiles is not
/// visible.
void preprocess(const FrameContext& frame, const ActivatedCloud& active, Visible& visible);

}  // namespace qs::cpu
