// SPDX-License-Identifier: MIT
#include "raster/scene/cloud_order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <glm/common.hpp>

#include "base/morton.h"
#include "base/rounding.h"
#include "raster/scene/activated_cloud.h"

namespace qs {
namespace {

template <class Key>
std::vector<std::uint32_t> sorted_by(const std::vector<Key>& keys) {
  std::vector<std::uint32_t> numbers(keys.size());
  std::iota(numbers.begin(), numbers.end(), 0u);
  std::stable_sort(numbers.begin(), numbers.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
  return numbers;
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
  std::sort(numbers.begin(), numbers.end());
  return select(cloud, numbers);
}

}  // namespace qs
