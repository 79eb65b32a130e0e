// SPDX-License-Identifier: MIT
#include "raster/scene/cloud_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include <glm/common.hpp>

#include "base/morton.h"
#include "base/rounding.h"
#include "raster/kernel/constants.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/radix_sort.h"

namespace qs {
namespace {

template <class Key>
std::vector<std::uint32_t> sorted_by(const std::vector<Key>& keys) {
  std::vector<std::uint32_t> numbers(keys.size());
  std::iota(numbers.begin(), numbers.end(), 0u);
  std::ranges::stable_sort(numbers,
                           [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
  return numbers;
}

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
  for (std::size_t i = 0; i < count; i += count / kSamples + 1)
    if (std::isfinite(value_of(i))) values.push_back(value_of(i));
  if (values.empty()) values.push_back(0);
  std::ranges::sort(values);
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

std::vector<std::uint32_t> largest_first(const GaussianCloud& cloud) {
  std::vector<double> keys(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3& s = cloud.log_scales[i];
    const float smallest = std::min({s.x, s.y, s.z});
    const float two = smallest == s.x ? s.y + s.z : smallest == s.y ? s.x + s.z : s.x + s.y;
    keys[i] = -opacity_of_logit(cloud.opacity_logits[i]) * std::exp(static_cast<double>(two));
  }
  return sorted_by(keys);
}

std::vector<std::uint32_t> morton_order(const GaussianCloud& cloud) {
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
  for (const glm::vec3& position : cloud.positions) {
    low = glm::min(low, glm::dvec3(position));
    high = glm::max(high, glm::dvec3(position));
  }
  std::vector<std::uint64_t> keys(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 t = (glm::dvec3(cloud.positions[i]) - low) /
                         glm::max(high - low, glm::dvec3(std::numeric_limits<double>::min()));
    const auto cell = [&t](int axis) { return round_to_integer(t[axis] * 0x1fffff, 0x1fffff); };
    keys[i] = morton_code(cell(0), cell(1), cell(2));
  }
  return sorted_by(keys);
}

GaussianCloud select(const GaussianCloud& cloud, std::span<const std::uint32_t> numbers) {
  GaussianCloud result;
  result.resize(numbers.size(), cloud.sh_degree);
  result.antialiased = cloud.antialiased;
  result.origin = cloud.origin;
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t from = numbers[i];
    result.positions[i] = cloud.positions[from];
    result.log_scales[i] = cloud.log_scales[from];
    result.rotations[i] = cloud.rotations[from];
    result.opacity_logits[i] = cloud.opacity_logits[from];
    std::copy_n(&cloud.sh[from * coefficients], coefficients, &result.sh[i * coefficients]);
  }
  return result;
}

GaussianCloud keep_largest(GaussianCloud cloud, std::size_t count) {
  if (count >= cloud.size()) return cloud;
  std::vector<std::uint32_t> numbers = largest_first(cloud);
  numbers.resize(count);
  std::ranges::sort(numbers);
  return select(cloud, numbers);
}

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
