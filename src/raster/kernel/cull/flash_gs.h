// SPDX-License-Identifier: MIT
//
// Mode `flashgs`: the precise intersection of FlashGS (Feng et al., arXiv 2408.07967). It lists a
// tile of the ellipse's bounding box if and only if the ellipse alpha = 1/255 meets the tile's
// rectangle: the centre is in the tile, or one of the tile's four edges crosses the ellipse, by the
// roots of a quadratic equation. A tile is the square between its borders.
#pragma once

#include "raster/kernel/cull/tested_tiles.h"

namespace qs {

template <int kTilePx>
struct EdgeTest {
  glm::vec2 mean;
  glm::vec3 conic;
  float gamma;

  QS_HD bool meets(int column, int row) const {
    const float left = static_cast<float>(column * kTilePx) - mean.x, right = left + kTilePx;
    const float top = static_cast<float>(row * kTilePx) - mean.y, bottom = top + kTilePx;
    if (left <= 0.0f && right >= 0.0f && top <= 0.0f && bottom >= 0.0f) return true;
    return crosses(conic.x, conic.z, left, top, bottom) ||
           crosses(conic.x, conic.z, right, top, bottom) ||
           crosses(conic.z, conic.x, top, left, right) ||
           crosses(conic.z, conic.x, bottom, left, right);
  }

 private:
  /// True if the ellipse p u^2 + 2b u v + r v^2 <= gamma meets the edge at `u`, low <= v <= high.
  QS_HD bool crosses(float p, float r, float u, float low, float high) const {
    const float b = conic.y;
    const float discriminant = (b * b - p * r) * u * u + gamma * r;
    if (!(discriminant >= 0.0f)) return false;
    const float root = sqrtf(discriminant), middle = -b * u;
    return middle - root <= high * r && middle + root >= low * r;
  }
};

struct FlashGs {
  static constexpr const char* kName = "flashgs";

  template <int kTilePx = kTileSize>
  static QS_HD TestedWalk<EdgeTest<kTilePx>> walk(const Footprint& footprint, TileGrid grid) {
    return TestedWalk<EdgeTest<kTilePx>>::over(
        tiles_of_plain_box<kTilePx>(footprint, grid),
        {footprint.mean_px, footprint.conic, footprint.gamma});
  }
};

}  // namespace qs
