// SPDX-License-Identifier: MIT
//
// Mode `stopthepop`: the tile-based culling of StopThePop (Radl et al., arXiv 2402.00525). It drops
// a tile if the Gaussian's largest contribution in the tile is below 1/255. That contribution is at
// the centre if the tile contains it, else on one of the (at most two) edges that face the centre,
// where it has a closed form. A tile is the square of its pixel centres. The candidates are the
// tiles of the square whose half side is the ellipse's longer half axis, so that only the test
// decides.
#pragma once

#include "raster/kernel/cull/square.h"
#include "raster/kernel/cull/tested_tiles.h"

namespace qs {

/// True if alpha reaches 1/255 within a tile's square of pixel centres; exponents are compared.
template <int kTilePx>
struct LargestAlphaTest {
  glm::vec2 mean;
  glm::vec3 conic;
  float gamma;

  QS_HD bool meets(int column, int row) const {
    const float left = static_cast<float>(column * kTilePx) - mean.x, right = left + (kTilePx - 1);
    const float top = static_cast<float>(row * kTilePx) - mean.y, bottom = top + (kTilePx - 1);
    const float x = nearest_to_zero(left, right), y = nearest_to_zero(top, bottom);
    const float at_x = smallest_on_edge(conic.x, conic.z, x, top, bottom);
    const float at_y = smallest_on_edge(conic.z, conic.x, y, left, right);
    // An edge faces the centre if its coordinate is not 0; with both 0 the centre is inside.
    const float smallest =
        x == 0.0f ? (y == 0.0f ? 0.0f : at_y) : (y == 0.0f || at_x < at_y ? at_x : at_y);
    return smallest <= gamma;
  }

 private:
  static QS_HD float nearest_to_zero(float low, float high) {
    return low > 0.0f ? low : (high < 0.0f ? high : 0.0f);
  }

  /// The smallest p u^2 + 2b u v + r v^2 over low <= v <= high.
  QS_HD float smallest_on_edge(float p, float r, float u, float low, float high) const {
    const float v = clamped(-conic.y * u / r, low, high);
    return p * u * u + 2.0f * conic.y * u * v + r * v * v;
  }
};

struct StopThePop {
  static constexpr const char* kName = "stopthepop";

  template <int kTilePx = kTileSize>
  static QS_HD TestedWalk<LargestAlphaTest<kTilePx>> walk(const Footprint& footprint,
                                                          TileGrid grid) {
    const float half = sqrtf(footprint.gamma * Square::larger_variance(footprint));
    return TestedWalk<LargestAlphaTest<kTilePx>>::over(
        tiles_of_box<kTilePx>(footprint.mean_px, glm::vec2(half), grid),
        {footprint.mean_px, footprint.conic, footprint.gamma});
  }
};

}  // namespace qs
