// SPDX-License-Identifier: MIT
//
// Mode `3dgs`: the square of half side ceil(3 sqrt(lambda_max)) with the integer tile rule of the
// original 3DGS rasterizer (Kerbl et al. 2023). It ignores opacity and cuts at 3 sigma. Of a solid
// ellipse it is the square around it; the tile rule loses up to a pixel of a square.
#pragma once

#include "raster/kernel/cull/culler.h"

namespace qs {

struct Square {
  static constexpr const char* kName = "3dgs";

  /// The covariance's larger eigenvalue, px^2. Its root has a lower bound, as in 3DGS.
  static QS_HD float larger_variance(const Footprint& footprint, float floor = kEigenvalueFloor) {
    const float mid = 0.5f * (footprint.covariance.xx + footprint.covariance.yy);
    const float discriminant = mid * mid - footprint.determinant;
    const float root = sqrtf(discriminant > floor ? discriminant : floor);
    return mid + root;
  }

  /// Half side in pixels.
  static QS_HD float radius(const Footprint& footprint) {
    if (footprint.is_solid())
      return ceilf(sqrtf(footprint.gamma * larger_variance(footprint, 0.0f)) + 1.0f);
    return ceilf(kSigmas * sqrtf(larger_variance(footprint)));
  }

  /// Tiles int((p - r) / n) .. int((p + r + n - 1) / n) - 1 along one axis, n = kTilePx.
  template <int kTilePx = kTileSize>
  static QS_HD Span tiles(float center, float radius, int limit) {
    constexpr float kInverse = 1.0f / kTilePx;
    return {clamp_to_int((center - radius) * kInverse, limit),
            clamp_to_int((center + radius + (kTilePx - 1)) * kInverse, limit)};
  }

  template <int kTilePx = kTileSize>
  static QS_HD RectWalk walk(const Footprint& footprint, TileGrid grid) {
    const float r = radius(footprint);
    return RectWalk::over({tiles<kTilePx>(footprint.mean_px.x, r, grid.columns),
                           tiles<kTilePx>(footprint.mean_px.y, r, grid.rows)});
  }
};

}  // namespace qs
