// SPDX-License-Identifier: MIT
#include "learn/step/model_state.h"

#include <algorithm>
#include <utility>

#include "learn/gradient/activation.h"

namespace qs::train {

AdamState AdamState::like(const Parameters& parameters) {
  AdamState state;
  state.first.resize_like(parameters);
  state.second.resize_like(parameters);
  return state;
}

void DensityStatistics::reset(std::size_t gaussians) {
  sums.assign(gaussians, 0);
  views.assign(gaussians, 0);
  absolute.clear();
}

float DensityStatistics::mean(std::size_t i) const {
  return views[i] == 0 ? 0 : sums[i] / static_cast<float>(views[i]);
}

float DensityStatistics::mean_absolute(std::size_t i) const {
  return absolute.empty() || views[i] == 0 ? 0 : absolute[i] / static_cast<float>(views[i]);
}

FieldState FieldState::starting_with(ColorField field) {
  FieldState state;
  state.first.resize(field.grid_values.size() + field.weights.size());
  state.second.resize(state.first.size());
  state.field = std::move(field);
  return state;
}

ModelState ModelState::starting_with(Parameters parameters) {
  ModelState state;
  state.adam = AdamState::like(parameters);
  state.density.reset(parameters.size());
  state.parameters = std::move(parameters);
  return state;
}

std::size_t count_existing(const Parameters& parameters) {
  if (!parameters.has_masks) return parameters.size();
  return static_cast<std::size_t>(std::ranges::count_if(
      parameters.mask_logits, [](float logit) { return !masked_out(double{logit}); }));
}

GaussianCloud to_cloud(const Parameters& parameters, bool antialiased) {
  GaussianCloud cloud;
  cloud.resize(count_existing(parameters), parameters.sh_degree);
  cloud.antialiased = antialiased;
  const std::size_t stride = parameters.sh_stride();
  std::size_t to = 0;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters.is_masked_out(i)) continue;
    cloud.positions[to] = parameters.means[i];
    cloud.log_scales[to] = parameters.log_scales[i];
    cloud.opacity_logits[to] = parameters.opacity_logits[i];
    cloud.rotations[to] = glm::quat(unit_rotation(glm::dquat(parameters.rotations[i])));
    std::copy_n(&parameters.sh[i * stride], stride, &cloud.sh[to * stride]);
    ++to;
  }
  return cloud;
}

Parameters from_cloud(const GaussianCloud& cloud) {
  Parameters parameters;
  parameters.sh_degree = cloud.sh_degree;
  parameters.means.assign(cloud.positions.begin(), cloud.positions.end());
  parameters.log_scales.assign(cloud.log_scales.begin(), cloud.log_scales.end());
  parameters.rotations.assign(cloud.rotations.begin(), cloud.rotations.end());
  parameters.opacity_logits.assign(cloud.opacity_logits.begin(), cloud.opacity_logits.end());
  parameters.sh.assign(cloud.sh.begin(), cloud.sh.end());
  return parameters;
}

}  // namespace qs::train
