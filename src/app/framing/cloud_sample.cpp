// SPDX-License-Identifier: MIT
#include "app/framing/cloud_sample.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "app/framing/huge_gaussians.h"

namespace qs {
namespace {

bool is_finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool is_drawable(const GaussianCloud& cloud, std::size_t i) {
  constexpr float kLargest = 80;  // exp(80) is finite
  const glm::vec3 size = cloud.log_scales[i];
  const glm::quat turn = cloud.rotations[i];
  const float squared = glm::dot(turn, turn);
  return is_finite(cloud.positions[i]) && size.x < kLargest && size.y < kLargest &&
         size.z < kLargest && !std::isnan(cloud.opacity_logits[i]) && std::isfinite(squared) &&
         squared > 0;
}

}  // namespace

CloudSample sample_of(const GaussianCloud& cloud, std::size_t most) {
  const std::size_t step = sample_step(cloud.size(), most);
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  CloudSample sample;
  GaussianCloud& kept = sample.gaussians;
  kept.antialiased = cloud.antialiased;
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

}  // namespace qs
