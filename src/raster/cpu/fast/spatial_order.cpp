// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/spatial_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "raster/cpu/fast/radix_sort.h"
#include "raster/scene/morton.h"

namespace qs::cpu::fast {
namespace {

/// Cells along an axis; codes have three times as many bits, three passes of the sort.
constexpr int kCellBits = 10;
constexpr float kCells = 1 << kCellBits;

/// Where cells lie along one axis. Those at the ends reach to infinity.
struct Axis {
  float begin = 0, cells_per_unit = 0;

  std::uint32_t cell(float value) const {
    const float t = (value - begin) * cells_per_unit;
    if (!(t > 0)) return 0;
    return t < kCells ? static_cast<std::uint32_t>(t) : (1u << kCellBits) - 1;
  }
};

/// Cells over what most of a sample covers, with half of that to spare on either side: a few
/// Gaussians far away, which captures of the outdoors have, would leave the rest in a few cells.
Axis axis_of(std::span<const glm::vec3> positions, int axis) {
  constexpr std::size_t kSamples = 4096;
  std::vector<float> sample;
  const std::size_t step = positions.size() / kSamples + 1;
  for (std::size_t i = 0; i < positions.size(); i += step) {
    const float value = positions[i][axis];
    if (std::isfinite(value)) sample.push_back(value);
  }
  if (sample.empty()) return {};
  const auto at = [&](std::size_t percent) {
    const auto nth = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() * percent / 100);
    std::nth_element(sample.begin(), nth, sample.end());
    return *nth;
  };
  const float low = at(2), high = at(98);
  const float range = std::max(high - low, std::numeric_limits<float>::min());
  return {low - 0.5f * range, kCells / (2 * range)};
}

}  // namespace

Array<std::uint32_t> spatial_order(std::span<const glm::vec3> positions, ThreadPool& pool) {
  const std::array<Axis, 3> axes{axis_of(positions, 0), axis_of(positions, 1),
                                 axis_of(positions, 2)};
  SortItems items;
  items.resize(positions.size());
  pool.for_chunks(positions.size(), 16384, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const glm::vec3& p = positions[i];
      items.keys[i] = static_cast<std::uint32_t>(
          morton_code(axes[0].cell(p.x), axes[1].cell(p.y), axes[2].cell(p.z)));
      items.values[i] = static_cast<std::uint32_t>(i);
    }
  });
  radix_sort(items, {0, (1u << 3 * kCellBits) - 1}, pool);
  return std::move(items.values);
}

}  // namespace qs::cpu::fast
