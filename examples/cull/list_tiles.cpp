// SPDX-License-Identifier: MIT
// Lists the tiles of a Gaussian in every culling mode, as vector border-16 of cull.json has them.
#include <cmath>
#include <cstdio>
#include <string>

#include <quadsplat/cull/modes.h>

namespace {

/// A letter per tile, row by row: '#' if mode P lists it.
template <class P>
std::string map_of(const qs::Footprint& footprint, const qs::TileGrid& grid) {
  std::string map;
  for (int row = 0; row < grid.rows; ++row)
    map += std::string(row > 0, '/') + std::string(grid.columns, '.');
  qs::for_each_tile<P>(footprint, grid, [&](int tile) { map[tile + tile / grid.columns] = '#'; });
  return map;
}

}  // namespace

int main() {
  // A Gaussian projected to the image: its mean, covariance (xx, xy, yy) and opacity.
  const glm::vec2 mean_px(64.0f, 64.0f);
  const qs::Covariance2<float> covariance{352.592926f, 370.484192f, 400.15683f};
  const float opacity = 0.152602926f, gamma = 2.0f * std::log(255.0f * opacity);
  const qs::Footprint footprint = qs::make_footprint(mean_px, covariance, gamma);
  const qs::TileGrid grid = qs::TileGrid::of_image(160, 128);
  for (qs::CullMode mode = 1; mode <= qs::kModeCount; ++mode) {
    qs::with_culler(mode, [&]<class P>(P) {
      std::printf("%s %u %s\n", P::kName, qs::count_tiles<P>(footprint, grid),
                  map_of<P>(footprint, grid).c_str());
    });
  }
}
