// SPDX-License-Identifier: MIT
#include "raster/scene/cells.h"

#include <limits>

#include "base/rank.h"

namespace qs {

float log_size(const GaussianCloud& cloud, std::size_t i) {
  const glm::vec3& s = cloud.log_scales[i];
  return std::isnan(s.x + s.y + s.z) ? std::numeric_limits<float>::quiet_NaN()
                                     : std::max({s.x, s.y, s.z});
}

std::optional<CellGrid> CellGrid::around(const GaussianCloud& cloud,
                                         std::span<const std::uint32_t> of) {
  auto sizes = finite_values(of, [&](std::uint32_t i) { return log_size(cloud, i); });
  if (sizes.empty()) return std::nullopt;
  CellGrid grid;
  grid.median = quantile(sizes, 0.5);
  grid.cell = double{kCellSigmas} * std::exp(double{grid.median});
  if (!(grid.cell > 0) || !std::isfinite(grid.cell)) return std::nullopt;
  for (int axis = 0; axis < 3; ++axis) {
    auto values = finite_values(of, [&](std::uint32_t i) {
      const glm::vec3& p = cloud.positions[i];
      return is_finite(p) ? p[axis] : std::numeric_limits<float>::infinity();
    });
    if (!values.empty()) grid.middle[axis] = double{quantile(values, 0.5)};
  }
  return grid;
}

std::optional<std::uint64_t> CellGrid::key(glm::vec3 position) const {
  constexpr std::int64_t kMiddle = std::int64_t{1} << (kFieldBits - 1), kLast = 2 * kMiddle - 4;
  if (!is_finite(position)) return std::nullopt;
  const glm::dvec3 at = glm::floor((glm::dvec3(position) - middle) / cell);
  std::uint64_t fields[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double clamped = std::clamp(at[axis], -double{kMiddle}, double{kLast - kMiddle});
    fields[axis] = static_cast<std::uint64_t>(static_cast<std::int64_t>(clamped) + kMiddle);
  }
  return key_of(fields[0], fields[1], fields[2]);
}

}  // namespace qs
