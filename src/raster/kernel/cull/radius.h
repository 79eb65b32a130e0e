// SPDX-License-Identifier: MIT
//
// The radii of a footprint as published training code returns them; densification and pruning read
// them. No culling mode depends on them.
#pragma once

#include <cmath>

#include <glm/vec2.hpp>

#include "raster/kernel/cull/square.h"

namespace qs {

/// diff-gaussian-rasterization (Kerbl et al. 2023), and gsplat (Ye et al. 2024, arXiv 2409.06765)
/// until version 1.4 and since version 1.5.
enum class RadiusRule { inria, gsplat_1_4, gsplat_1_5 };

/// Half sizes in pixels along x and y, whole numbers; 0 if the rule does not draw the Gaussian.
/// `opacity` includes the compensation. The image has `width` x `height` pixels. CPU and GPU get
/// the same bits.
QS_HD glm::ivec2 radii_of(RadiusRule rule, const Footprint& footprint, float opacity, int width,
                          int height) {
  constexpr int kLargest = 1 << 30;
  const Covariance2<float>& c = footprint.covariance;
  if (rule == RadiusRule::inria) {
    if (!lists_a_tile<Square>(footprint, TileGrid::of_image(width, height))) return {0, 0};
    return glm::ivec2(clamp_to_int(Square::radius(footprint), kLargest));
  }
  glm::vec2 radii;
  if (rule == RadiusRule::gsplat_1_4) {
    const float mid = 0.5f * (c.xx + c.yy);
    const float root = sqrtf(fmaxf(0.01f, mid * mid - footprint.determinant));
    radii = glm::vec2(ceilf(kSigmas * sqrtf(mid + root)));
  } else {
    if (!(opacity >= kAlphaMin)) return {0, 0};
    // gamma of an alpha of at least 1/255; log2_portable() is for arguments of at most 1.
    const float gamma = -2 * static_cast<float>(kLn2) * log2_portable(kAlphaMin / opacity);
    const float sigmas = fminf(3.33f, sqrtf(gamma));
    radii = {ceilf(sigmas * sqrtf(c.xx)), ceilf(sigmas * sqrtf(c.yy))};
  }
  // There, pixel i has its centre at i + 0.5.
  const glm::vec2 mean = footprint.mean_px + 0.5f;
  const auto size = glm::vec2(width, height);
  for (int axis = 0; axis < 2; ++axis)
    if (mean[axis] + radii[axis] <= 0 || mean[axis] - radii[axis] >= size[axis]) return {0, 0};
  return {clamp_to_int(radii.x, kLargest), clamp_to_int(radii.y, kLargest)};
}

}  // namespace qs
