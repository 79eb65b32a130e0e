// SPDX-License-Identifier: MIT
#include "app/framing/subject.h"

#include <algorithm>
#include <cmath>

namespace qs {
namespace {

constexpr std::size_t kSide = 48;  ///< cells along a side of the grid
constexpr std::size_t kCells = kSide * kSide * kSide;
constexpr std::size_t kSteps[] = {1, kSide, kSide* kSide};  ///< to the next cell along an axis
constexpr float kCellsInCore = 8;  ///< along the longest side of the middle half of the opacity
constexpr double kLeastGroup = 0.1;

/// A grid of cells around the middle of the scene. Far outliers are outside of it.
class Grid {
 public:
  Grid(const SceneBox& core)
      : cell_(largest_of(core.size()) / kCellsInCore), low_(core.center() - 0.5f * kSide * cell_) {}

  bool degenerate() const { return !(cell_ > 0); }

  /// kCells outside of the grid.
  std::size_t cell_of(const glm::vec3& position) const {
    const glm::vec3 at = (position - low_) / cell_;
    const auto inside = [](float x) { return x >= 0 && x < kSide; };
    if (!inside(at.x) || !inside(at.y) || !inside(at.z)) return kCells;
    const glm::uvec3 cell(at);
    return cell.x + kSide * (cell.y + kSide * cell.z);
  }

 private:
  float cell_;
  glm::vec3 low_;
};

// Sums every cell with its neighbours.
void smooth(std::vector<float>& grid) {
  for (const std::size_t step : kSteps) {
    const std::vector<float> before = grid;
    for (std::size_t i = 0; i < kCells; ++i) {
      const std::size_t at = i / step % kSide;
      if (at > 0) grid[i] += before[i - step];
      if (at < kSide - 1) grid[i] += before[i + step];
    }
  }
}

// Removes the dense cells of small groups: `dense` becomes false where a connected group of cells
// holds little of the opacity in `mass`.
void keep_large_groups(std::vector<std::uint8_t>& dense, const std::vector<float>& mass) {
  constexpr std::size_t kNone = kCells;
  std::vector<std::size_t> group(kCells, kNone), waiting;
  std::vector<double> sums;
  const auto join = [&](std::size_t cell) {
    if (!dense[cell] || group[cell] != kNone) return;
    group[cell] = sums.size() - 1;
    waiting.push_back(cell);
  };
  for (std::size_t start = 0; start < kCells; ++start) {
    if (!dense[start] || group[start] != kNone) continue;
    sums.push_back(0);
    join(start);
    while (!waiting.empty()) {
      const std::size_t i = waiting.back();
      waiting.pop_back();
      sums.back() += static_cast<double>(mass[i]);
      for (const std::size_t step : kSteps) {
        const std::size_t at = i / step % kSide;
        if (at > 0) join(i - step);
        if (at < kSide - 1) join(i + step);
      }
    }
  }
  if (sums.empty()) return;
  const double least = kLeastGroup * *std::max_element(sums.begin(), sums.end());
  for (std::size_t i = 0; i < dense.size(); ++i) dense[i] = dense[i] && sums[group[i]] >= least;
}

// The cells that belong to the subject.
std::vector<std::uint8_t> dense_cells(const Grid& grid, const CloudSample& sample,
                                      double least_density) {
  std::vector<float> mass(kCells), density;
  for (std::size_t i = 0; i < sample.opacities.size(); ++i) {
    const std::size_t cell = grid.cell_of(sample.gaussians.positions[i]);
    if (cell < kCells) mass[cell] += sample.opacities[i];
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
      const std::size_t cell = grid.cell_of(positions[i]);
      subject.holds[i] = cell < kCells && dense[cell];
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
