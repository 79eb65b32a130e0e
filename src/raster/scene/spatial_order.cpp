// SPDX-License-Identifier: MIT
#include "raster/scene/spatial_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/morton.h"
#include "raster/kernel/constants.h"
#include "raster/scene/radix_sort.h"

namespace qs {
namespace {

/// Cells along an axis. A key has three times as many bits and two for the size class, which the
/// sort needs three passes for.
constexpr int kCellBits = 10;
constexpr std::uint32_t kCells = 1u << kCellBits;

/// Size classes: up to 2, 4 and 8 times the median, and larger.
constexpr float kClasses = 4;

constexpr auto kSpread = [] {
  std::array<std::uint32_t, kCells> spread{};
  for (std::uint32_t i = 0; i < kCells; ++i) spread[i] = static_cast<std::uint32_t>(spread_bits(i));
  return spread;
}();

/// Cells of equal length along an axis. The first and last one extend to infinity.
struct Axis {
  float begin = 0, cells_per_unit = 0;
  float cells = kCells;

  std::uint32_t cell(float value) const {
    const float t = (value - begin) * cells_per_unit;
    return t > 0 ? static_cast<std::uint32_t>(std::min(t, cells - 1)) : 0;  // 0 of NaN
  }
};

/// value_of(i) of at most 4096 of the Gaussians, ascending, without values that are not finite.
template <class ValueOf>
std::vector<float> sample(std::size_t count, const ValueOf& value_of) {
  constexpr std::size_t kSamples = 4096;
  std::vector<float> values;
  for (std::size_t i = 0; i < count; i += count / kSamples + 1) {
    if (std::isfinite(value_of(i))) values.push_back(value_of(i));
  }
  if (values.empty()) values.push_back(0);
  std::sort(values.begin(), values.end());
  return values;
}

/// Cells over the range between the 2nd and 98th percentile, enlarged by half of it on either side.
/// The few distant Gaussians of outdoor scenes must not leave the others in a handful of cells.
Axis axis_of(const GaussianCloud& cloud, int axis) {
  const auto values = sample(cloud.size(), [&](std::size_t i) { return cloud.positions[i][axis]; });
  const float low = values[values.size() * 2 / 100], high = values[values.size() * 98 / 100];
  const float range = std::max(high - low, std::numeric_limits<float>::min());
  return {low - 0.5f * range, kCells / (2 * range)};
}

float log_size(const glm::vec3& log_scale) {
  return std::max({log_scale.x, log_scale.y, log_scale.z});
}

Axis classes_of(const GaussianCloud& cloud) {
  const auto sizes =
      sample(cloud.size(), [&](std::size_t i) { return log_size(cloud.log_scales[i]); });
  return {sizes[sizes.size() / 2], static_cast<float>(kLog2E), kClasses};
}

}  // namespace

Array<std::uint32_t> spatial_order(const GaussianCloud& cloud, ThreadPool& pool) {
  const Axis x = axis_of(cloud, 0), y = axis_of(cloud, 1), z = axis_of(cloud, 2);
  const Axis classes = classes_of(cloud);
  SortItems items;
  items.resize(cloud.size());
  pool.for_each(cloud.size(), 16384, [&](std::size_t i) {
    const glm::vec3& p = cloud.positions[i];
    items.keys[i] = classes.cell(log_size(cloud.log_scales[i])) << 3 * kCellBits |
                    kSpread[x.cell(p.x)] | kSpread[y.cell(p.y)] << 1 | kSpread[z.cell(p.z)] << 2;
    items.values[i] = static_cast<std::uint32_t>(i);
  });
  radix_sort(items, {0, ~0u}, pool);
  return std::move(items.values);
}

}  // namespace qs
