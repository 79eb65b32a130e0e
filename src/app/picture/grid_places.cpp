// SPDX-License-Identifier: MIT
#include "app/picture/grid_places.h"

#include <algorithm>

namespace qs {
namespace {

constexpr float kGap = 0.006f;  ///< around a picture
constexpr float kLeastSide = 0.01f;

}  // namespace

glm::vec2 GridPlaces::low(int index) const {
  const float width = 1.0f / static_cast<float>(columns), height = side + label + 2 * kGap;
  const auto column = static_cast<float>(index % columns);
  const auto row = static_cast<float>(index / columns);
  return {column * width + 0.5f * (width - side), row * height + kGap};
}

GridPlaces grid_places(int count, float label) {
  GridPlaces best{1, count, 0, label};
  for (int columns = 1; columns <= count; ++columns) {
    const int rows = (count + columns - 1) / columns;
    const float side = std::min(1.0f / static_cast<float>(columns) - 2 * kGap,
                                1.0f / static_cast<float>(rows) - label - 2 * kGap);
    if (side > best.side) best = {columns, rows, side, label};
  }
  best.side = std::max(best.side, kLeastSide);
  return best;
}

}  // namespace qs
