// SPDX-License-Identifier: MIT
#include "learn/step/model_state.h"

#include <utility>

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

}  // namespace qs::train
