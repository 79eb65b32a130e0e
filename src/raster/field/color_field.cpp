// SPDX-License-Identifier: MIT
#include "raster/field/color_field.h"

#include <algorithm>
#include <cmath>

namespace qs {

std::vector<GridLevel> grid_levels(const GridShape& shape) {
  std::vector<GridLevel> levels;
  const float log2_growth = std::log2(shape.growth);
  std::uint64_t first = 0;
  for (int number = 0; number < shape.levels; ++number) {
    GridLevel level;
    level.scale =
        std::exp2(static_cast<float>(number) * log2_growth) * static_cast<float>(shape.base) - 1;
    level.resolution = static_cast<std::uint32_t>(std::ceil(level.scale)) + 1;
    const std::uint64_t side = level.resolution, vertices = side * side * side;
    const std::uint64_t most = std::uint64_t{1} << shape.log2_entries;
    level.entries = static_cast<std::uint32_t>(std::min((vertices + 7) / 8 * 8, most));
    level.is_dense = vertices <= level.entries;
    level.first = first;
    first += level.entries;
    levels.push_back(level);
  }
  return levels;
}

std::size_t grid_value_count(const GridShape& shape) {
  const GridLevel last = grid_levels(shape).back();
  return (last.first + last.entries) * kGridFeatures;
}

}  // namespace qs
