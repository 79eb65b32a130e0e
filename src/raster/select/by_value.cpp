// SPDX-License-Identifier: MIT
#include "raster/select/by_value.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "raster/kernel/constants.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/cells.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

// All cells of a cloud, ascending, and the cell of each Gaussian.
struct Cells {
  static constexpr std::uint32_t kNone = 0xffffffff;
  std::vector<std::uint64_t> keys;
  std::vector<std::uint32_t> cell_of;  ///< kNone: not among them, or nowhere

  Cells(const GaussianCloud& cloud, const GaussianSet& among, ThreadPool& pool)
      : cell_of(cloud.size(), kNone) {
    const std::vector<std::uint32_t> numbers = among.numbers();
    const auto grid = CellGrid::around(cloud, numbers);
    if (!grid) return;
    for (const std::uint32_t i : numbers)
      if (const auto key = grid->key(cloud.positions[i])) keys.push_back(*key);
    std::ranges::sort(keys);
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    pool.for_each(numbers.size(), 4096, [&](std::size_t k) {
      if (const auto key = grid->key(cloud.positions[numbers[k]]))
        cell_of[numbers[k]] = static_cast<std::uint32_t>(find(*key) - keys.begin());
    });
  }

  std::vector<std::uint64_t>::const_iterator find(std::uint64_t key) const {
    return std::ranges::lower_bound(keys, key);
  }

  /// Calls visit(cell) for a cell and its neighbours.
  template <class Visit>
  void around(std::size_t cell, const Visit& visit) const {
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y) {
        const std::uint64_t middle = keys[cell] + CellGrid::step(0, y, z);
        for (auto at = find(middle - 1); at != keys.end() && *at <= middle + 1; ++at)
          visit(static_cast<std::size_t>(at - keys.begin()));
      }
  }

  /// The cells of the set, widened by their neighbours.
  std::vector<char> around(const GaussianSet& set) const {
    std::vector<char> own(keys.size()), wide(keys.size());
    set.for_each([&](std::size_t i) {
      if (cell_of[i] != kNone) own[cell_of[i]] = 1;
    });
    for (std::size_t cell = 0; cell < own.size(); ++cell)
      if (own[cell] != 0) around(cell, [&](std::size_t at) { wide[at] = 1; });
    return wide;
  }
};

GaussianSet in_cells(const Cells& cells, const std::vector<char>& marked, ThreadPool& pool) {
  return GaussianSet::where(cells.cell_of.size(), pool, [&](std::size_t i) {
    return cells.cell_of[i] != Cells::kNone && marked[cells.cell_of[i]] != 0;
  });
}

}  // namespace

GaussianSet gaussians_of_opacity(const GaussianCloud& cloud, ValueRange range, ThreadPool& pool) {
  return GaussianSet::where(cloud.size(), pool, [&](std::size_t i) {
    return range.contains(opacity_of_logit(cloud.opacity_logits[i]));
  });
}

GaussianSet gaussians_of_size(const GaussianCloud& cloud, ValueRange range, ThreadPool& pool) {
  return GaussianSet::where(cloud.size(), pool, [&](std::size_t i) {
    return range.contains(std::exp(double{log_size(cloud, i)}));
  });
}

GaussianSet gaussians_at_distance(const GaussianCloud& cloud, glm::dvec3 point,
                                  std::optional<glm::dvec3> normal, ValueRange range,
                                  ThreadPool& pool) {
  const glm::dvec3 unit = normal ? glm::normalize(*normal) : glm::dvec3(0);
  return GaussianSet::where(cloud.size(), pool, [&](std::size_t i) {
    const glm::dvec3 offset = glm::dvec3(cloud.positions[i]) - point;
    return range.contains(normal ? glm::dot(offset, unit) : glm::length(offset));
  });
}

glm::dvec3 lab_of(glm::dvec3 srgb) {
  static const glm::dmat3 kRows(0.4124564, 0.3575761, 0.1804375, 0.2126729, 0.7151522, 0.0721750,
                                0.0193339, 0.1191920, 0.9503041);
  const glm::dvec3 c = glm::clamp(srgb, 0.0, 1.0);
  const glm::dvec3 rgb(linear_of_srgb(c.r), linear_of_srgb(c.g), linear_of_srgb(c.b));
  const glm::dvec3 xyz = rgb * kRows / glm::dvec3(0.95047, 1, 1.08883);
  const double x = lab_root(xyz.x), y = lab_root(xyz.y), z = lab_root(xyz.z);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

glm::dvec3 base_srgb(const GaussianCloud& cloud, std::size_t i) {
  const auto count = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  return 0.5 + kSh0 * glm::dvec3(cloud.sh[i * count]);
}

glm::dvec3 base_lab(const GaussianCloud& cloud, std::size_t i) {
  return lab_of(base_srgb(cloud, i));
}

GaussianSet gaussians_of_color(const GaussianCloud& cloud, glm::dvec3 color, double tolerance,
                               ThreadPool& pool) {
  const glm::dvec3 lab = lab_of(color);
  return GaussianSet::where(cloud.size(), pool, [&](std::size_t i) {
    return glm::distance(base_lab(cloud, i), lab) <= tolerance;
  });
}

GaussianSet grown(const GaussianCloud& cloud, const GaussianSet& set, const GaussianSet& among,
                  int steps, ThreadPool& pool) {
  const Cells cells(cloud, among, pool);
  GaussianSet all = set;
  for (int step = 0; step < steps; ++step) all |= in_cells(cells, cells.around(all), pool);
  return all;
}

GaussianSet shrunk(const GaussianCloud& cloud, const GaussianSet& set, const GaussianSet& among,
                   int steps, ThreadPool& pool) {
  GaussianSet others = among;
  others -= set;
  GaussianSet rest = set;
  rest -= grown(cloud, others, among, steps, pool);
  return rest;
}

GaussianSet flooded(const GaussianCloud& cloud, const GaussianSet& set, const GaussianSet& among,
                    double tolerance, ThreadPool& pool) {
  if (set.empty()) return set;
  glm::dvec3 mean(0.0);
  set.for_each([&](std::size_t i) { mean += base_lab(cloud, i); });
  mean /= static_cast<double>(set.count());
  // Cells without Gaussians of that colour lead nowhere.
  GaussianSet alike = GaussianSet::where(cloud.size(), pool, [&](std::size_t i) {
    return among[i] && glm::distance(base_lab(cloud, i), mean) <= tolerance;
  });
  alike |= set;
  const Cells cells(cloud, among, pool);
  std::vector<char> has_alike(cells.keys.size()), reached(cells.keys.size());
  alike.for_each([&](std::size_t i) {
    if (cells.cell_of[i] != Cells::kNone) has_alike[cells.cell_of[i]] = 1;
  });
  std::vector<std::size_t> open;
  const auto reach = [&](std::size_t cell) {
    if (has_alike[cell] == 0 || reached[cell] != 0) return;
    reached[cell] = 1;
    open.push_back(cell);
  };
  set.for_each([&](std::size_t i) {
    if (cells.cell_of[i] != Cells::kNone) reach(cells.cell_of[i]);
  });
  while (!open.empty()) {
    const std::size_t cell = open.back();
    open.pop_back();
    cells.around(cell, reach);
  }
  GaussianSet all = in_cells(cells, reached, pool);
  all &= alike;
  all |= set;
  return all;
}

}  // namespace qs
