// SPDX-License-Identifier: MIT
#include "app/framing/subject.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "app/framing/scene_box.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {
namespace {

bool is_drawable(const GaussianCloud& cloud, std::size_t i) {
  constexpr float kLargest = 80;  // exp(80) is finite
  const glm::vec3 size = cloud.log_scales[i];
  const glm::quat turn = cloud.rotations[i];
  const float squared = glm::dot(turn, turn);
  return is_finite(cloud.positions[i]) && size.x < kLargest && size.y < kLargest &&
         size.z < kLargest && !std::isnan(cloud.opacity_logits[i]) && std::isfinite(squared) &&
         squared > 0;
}

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

Extent extent_along(const Subject& subject, glm::dvec3 direction, std::size_t every) {
  std::vector<double> values;
  std::vector<float> weights;
  for (std::size_t i = 0; i < subject.positions.size(); i += every) {
    values.push_back(glm::dot(direction, glm::dvec3(subject.positions[i])));
    weights.push_back(subject.weights[i]);
  }
  const Quantiles quantiles(values, weights);
  return {quantiles.at(0.05), quantiles.at(0.95)};
}

}  // namespace

CloudSample sample_of(const GaussianCloud& cloud, std::size_t most) {
  const std::size_t step = sample_step(cloud.size(), most);
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  CloudSample sample;
  GaussianCloud& kept = sample.gaussians;
  kept.antialiased = cloud.antialiased;
  kept.origin = cloud.origin;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    if (!is_drawable(cloud, i)) continue;
    const glm::vec3 color = cloud.sh[i * coefficients];
    kept.positions.push_back(cloud.positions[i]);
    kept.log_scales.push_back(cloud.log_scales[i]);
    kept.rotations.push_back(cloud.rotations[i]);
    kept.opacity_logits.push_back(cloud.opacity_logits[i]);
    kept.sh.push_back(is_finite(color) ? color : glm::vec3(0));
  }
  drop_huge(kept);
  for (const float logit : kept.opacity_logits)
    sample.opacities.push_back(1 / (1 + std::exp(-logit)));
  std::vector<float>& opacities = sample.opacities;
  if (std::none_of(opacities.begin(), opacities.end(), [](float o) { return o > 0; }))
    std::fill(opacities.begin(), opacities.end(), 1.0f);
  sample.represented = static_cast<double>(step);
  return sample;
}

CloudSample sample_of(const SceneSample& sample) {
  CloudSample taken = sample_of(sample.scene.cloud, sample.scene.cloud.size());
  taken.represented = static_cast<double>(sample.step);
  return taken;
}

Quantiles::Quantiles(std::span<const double> values, std::span<const float> weights) {
  for (std::size_t i = 0; i < values.size(); ++i)
    sorted_.emplace_back(values[i], static_cast<double>(weights[i]));
  std::sort(sorted_.begin(), sorted_.end());
  double sum = 0;
  for (auto& [value, reached] : sorted_) reached = sum += reached;
}

double Quantiles::at(double fraction) const {
  if (sorted_.empty()) return 0;
  const auto found = std::lower_bound(
      sorted_.begin(), std::prev(sorted_.end()), fraction * sorted_.back().second,
      [](const std::pair<double, double>& item, double sum) { return item.second < sum; });
  return found->first;
}

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

Ground::Ground(const Subject& subject, glm::dvec3 upward) : up(upward) {
  constexpr int kStep = 5, kMost = 45;  // degrees
  constexpr double kSmaller = 0.9;
  constexpr std::size_t kMostExamined = 2000;
  const glm::dvec3 usual = std::abs(up.z) < 0.8 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  const glm::dvec3 straight = glm::normalize(usual - glm::dot(usual, up) * up);
  const glm::dvec3 across = glm::cross(straight, up);
  const auto turn = [&](int degrees) {
    const double angle = glm::radians(static_cast<double>(degrees));
    forward = std::cos(angle) * straight + std::sin(angle) * across;
    right = glm::cross(forward, up);
  };
  const auto area = [&](int degrees) {
    turn(degrees);
    const std::size_t every = 1 + subject.positions.size() / kMostExamined;
    return extent_along(subject, forward, every).size() *
           extent_along(subject, right, every).size();
  };
  int best = 0;
  double least = kSmaller * area(0);
  for (int degrees = -kMost; degrees < kMost; degrees += kStep) {
    const double here = area(degrees);
    if (here < least) least = here, best = degrees;
  }
  turn(best);
  height = extent_along(subject, up, 1);
  ahead = extent_along(subject, forward, 1);
  aside = extent_along(subject, right, 1);
}

}  // namespace qs
