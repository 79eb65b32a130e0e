// SPDX-License-Identifier: MIT
#include "app/framing/subject.h"

#include <algorithm>
#include <cmath>

namespace qs {
namespace {

constexpr int kSide = 48;  ///< cells along a side of the grid
constexpr int kCells = kSide * kSide * kSide;
constexpr float kCellsInCore = 8;  ///< along the longest side of the middle half of the opacity
constexpr double kLeastGroup = 0.1;

/// A grid of cells around the middle of the scene. Far outliers are outside of it.
class Grid {
 public:
  Grid(const SceneBox& core)
      : cell_(std::max({core.size().x, core.size().y, core.size().z}) / kCellsInCore),
        low_(core.center() - 0.5f * kSide * cell_) {}

  bool degenerate() const { return !(cell_ > 0); }

  /// -1 outside of the grid.
  int cell_of(const glm::vec3& position) const {
    const glm::vec3 at = (position - low_) / cell_;
    const auto inside = [](float x) { return x >= 0 && x < kSide; };
    if (!inside(at.x) || !inside(at.y) || !inside(at.z)) return -1;
    return static_cast<int>(at.x) +
           kSide * (static_cast<int>(at.y) + kSide * static_cast<int>(at.z));
  }

 private:
  float cell_;
  glm::vec3 low_;
};

// Sums every cell with its neighbours.
void smooth(std::vector<float>& grid) {
  for (const int step : {1, kSide, kSide * kSide}) {
    const std::vector<float> before = grid;
    for (int i = 0; i < kCells; ++i) {
      const int at = i / step % kSide;
      const auto value = [&](int j) { return before[static_cast<std::size_t>(j)]; };
      if (at > 0) grid[static_cast<std::size_t>(i)] += value(i - step);
      if (at < kSide - 1) grid[static_cast<std::size_t>(i)] += value(i + step);
    }
  }
}

// Removes the dense cells of small groups: `dense` becomes false where a connected group of cells
// holds little of the opacity in `mass`.
void keep_large_groups(std::vector<std::uint8_t>& dense, const std::vector<float>& mass) {
  std::vector<int> group(kCells, -1), waiting;
  std::vector<double> sums;
  for (int start = 0; start < kCells; ++start) {
    if (!dense[static_cast<std::size_t>(start)] || group[static_cast<std::size_t>(start)] >= 0)
      continue;
    const int number = static_cast<int>(sums.size());
    sums.push_back(0);
    waiting = {start};
    group[static_cast<std::size_t>(start)] = number;
    while (!waiting.empty()) {
      const int i = waiting.back();
      waiting.pop_back();
      sums.back() += static_cast<double>(mass[static_cast<std::size_t>(i)]);
      for (const int step : {1, kSide, kSide * kSide}) {
        const int at = i / step % kSide;
        for (const int way : {-1, 1}) {
          if (at + way < 0 || at + way >= kSide) continue;
          const auto next = static_cast<std::size_t>(i + way * step);
          if (!dense[next] || group[next] >= 0) continue;
          group[next] = number;
          waiting.push_back(static_cast<int>(next));
        }
      }
    }
  }
  if (sums.empty()) return;
  const double least = kLeastGroup * *std::max_element(sums.begin(), sums.end());
  for (std::size_t i = 0; i < dense.size(); ++i)
    dense[i] = dense[i] && sums[static_cast<std::size_t>(group[i])] >= least;
}

// The cells that belong to the subject.
std::vector<std::uint8_t> dense_cells(const Grid& grid, const CloudSample& sample,
                                      double least_density) {
  std::vector<float> mass(kCells), density;
  for (std::size_t i = 0; i < sample.opacities.size(); ++i) {
    const int cell = grid.cell_of(sample.gaussians.positions[i]);
    if (cell >= 0) mass[static_cast<std::size_t>(cell)] += sample.opacities[i];
  }
  density = mass;
  smooth(density);
  // The typical density: the median, in which a cell counts by its opacity and its density.
  std::vector<double> values;
  std::vector<float> weights;
  for (std::size_t i = 0; i < mass.size(); ++i) {
    if (mass[i] <= 0) continue;
    values.push_back(static_cast<double>(density[i]));
    weights.push_back(mass[i] * density[i]);
  }
  const double least = least_density * Quantiles(values, weights).at(0.5);
  std::vector<std::uint8_t> dense(kCells);
  for (std::size_t i = 0; i < density.size(); ++i)
    dense[i] = density[i] > 0 && static_cast<double>(density[i]) >= least;
  keep_large_groups(dense, mass);
  return dense;
}

SceneBox weighted_box(std::span<const glm::vec3> positions, const std::vector<float>& weights,
                      double low, double high) {
  SceneBox box;
  std::vector<double> values(positions.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(positions.begin(), positions.end(), values.begin(),
                   [axis](const glm::vec3& p) { return static_cast<double>(p[axis]); });
    const Quantiles quantiles(values, weights);
    box.low[axis] = static_cast<float>(quantiles.at(low));
    box.high[axis] = static_cast<float>(quantiles.at(high));
  }
  return box;
}

}  // namespace

Subject find_subject(const CloudSample& sample, double least_density) {
  const auto& positions = sample.gaussians.positions;
  Subject subject;
  subject.holds.assign(positions.size(), 1);
  const Grid grid(weighted_box(positions, sample.opacities, 0.25, 0.75));
  if (!grid.degenerate()) {
    const std::vector<std::uint8_t> dense = dense_cells(grid, sample, least_density);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const int cell = grid.cell_of(positions[i]);
      subject.holds[i] = cell >= 0 && dense[static_cast<std::size_t>(cell)];
    }
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!subject.holds[i]) continue;
    subject.positions.push_back(positions[i]);
    subject.weights.push_back(sample.opacities[i]);
  }
  subject.box = weighted_box(subject.positions, subject.weights, 0.05, 0.95);
  return subject;
}

}  // namespace qs
