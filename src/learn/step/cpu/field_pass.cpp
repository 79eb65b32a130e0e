// SPDX-License-Identifier: MIT
#include "learn/step/cpu/field_pass.h"

#include "learn/gradient/adam.h"
#include "learn/gradient/color_field.h"

namespace qs::cpu::train {

template <class Real>
void add_field_gradients(const FieldGradient<Real>& field, const Parameters<Real>& parameters,
                         const glm::vec<3, Real>& eye,
                         const std::vector<glm::vec<3, Real>>& d_colors, ThreadPool& pool,
                         Gradients<Real>& gradients) {
  using Vec3 = glm::vec<3, Real>;
  const std::size_t weights = gradients.by_field.weights.size(), count = parameters.size();
  const std::size_t size = field_block_size(count);
  std::vector<Real>& sums = gradients.by_field.block_weights;
  sums.assign(kFieldBlocks * weights, 0);
  pool.for_each(kFieldBlocks, 1, [&](std::size_t block) {
    const std::span<Real> own(&sums[block * weights], weights);
    for (std::size_t position = 0; position < size; ++position) {
      const std::size_t i = field_gaussian(block, position);
      if (i >= count || d_colors[i] == Vec3(0)) continue;
      const Vec3 color = field_color(field, parameters.means[i], eye);
      const Vec3 d_output = output_gradient(color, d_colors[i]);
      if (d_output == Vec3(0)) continue;
      const Vec3 by_direction =
          field.add(parameters.means[i], eye, d_output, gradients.by_field.grid, own);
      gradients.by.means[i] += direction_gradient(parameters.means[i] - eye, by_direction);
    }
  });
  pool.for_each(weights, 1024, [&](std::size_t k) {
    for (std::size_t block = 0; block < kFieldBlocks; ++block)
      gradients.by_field.weights[k] += sums[block * weights + k];
  });
}

template decltype(add_field_gradients<float>) add_field_gradients<float>;
template decltype(add_field_gradients<double>) add_field_gradients<double>;

void take_field_step(const FieldGradients<float>& gradients, double rate,
                     qs::train::FieldState& state, ThreadPool& pool) {
  const AdamStep step = AdamStep::number(++state.steps);
  const std::size_t grid = state.field.grid_values.size();
  pool.for_each(state.first.size(), 4096, [&](std::size_t i) {
    const bool of_grid = i < grid;
    float& value = of_grid ? state.field.grid_values[i] : state.field.weights[i - grid];
    const float by =
        of_grid ? static_cast<float>(gradients.grid.sum(i)) : gradients.weights[i - grid];
    // Adam would leave a value that never had a gradient as it is.
    if (by == 0 && state.first[i] == 0 && state.second[i] == 0) return;
    adam(step, static_cast<float>(rate), by, value, state.first[i], state.second[i]);
  });
}

}  // namespace qs::cpu::train
