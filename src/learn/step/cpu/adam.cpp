// SPDX-License-Identifier: MIT
#include "learn/step/cpu/adam.h"

#include <type_traits>
#include <utility>

namespace qs::cpu::train {

void take_step(Parameters<float>& parameters, const Parameters<float>& gradient, const Rates& rates,
               AdamState& state, ThreadPool& pool, bool moves_rest) {
  const AdamStep step_of_most = AdamStep::number(++state.steps);
  if (moves_rest) ++state.rest_steps;
  const AdamStep step_of_rest = moves_rest ? AdamStep::number(state.rest_steps) : AdamStep{};
  const std::size_t stride = parameters.sh_stride();
  // Steps `count` values of Gaussian i, whose first one of each array `first` returns.
  const auto values = [&](const AdamStep& step, double rate, int count, float* value,
                          const float* by, float* first, float* second) {
    for (int k = 0; k < count; ++k)
      adam(step, static_cast<float>(rate), by[k], value[k], first[k], second[k]);
  };
  pool.for_each(parameters.size(), 1024, [&](std::size_t i) {
    const auto vector = [&](double rate, int count, auto array, std::size_t at,
                            const AdamStep& step) {
      values(step, rate, count, &(parameters.*array)[at][0], &(gradient.*array)[at][0],
             &(state.first.*array)[at][0], &(state.second.*array)[at][0]);
    };
    using P = Parameters<float>;
    vector(rates.mean, 3, &P::means, i, step_of_most);
    vector(rates.log_scale, 3, &P::log_scales, i, step_of_most);
    vector(rates.rotation, 4, &P::rotations, i, step_of_most);
    values(step_of_most, rates.opacity, 1, &parameters.opacity_logits[i],
           &gradient.opacity_logits[i], &state.first.opacity_logits[i],
           &state.second.opacity_logits[i]);
    if (parameters.has_masks) {
      values(step_of_most, rates.mask, 1, &parameters.mask_logits[i], &gradient.mask_logits[i],
             &state.first.mask_logits[i], &state.second.mask_logits[i]);
    }
    vector(rates.sh_dc, 3, &P::sh, i * stride, step_of_most);
    for (std::size_t k = 1; k < stride && moves_rest; ++k)
      vector(rates.sh_rest, 3, &P::sh, i * stride + k, step_of_rest);
  });
}

void add_gradients(const Parameters<float>& gradient, ThreadPool& pool, Parameters<float>& sums) {
  sums.resize_like(gradient);
  qs::train::for_each_array(
      [&](std::size_t values, const auto& from, auto& to) {
        pool.for_chunks(gradient.size(), 1024, [&](std::size_t begin, std::size_t end, int) {
          for (std::size_t i = begin * values; i < end * values; ++i) {
            if constexpr (std::is_same_v<decltype(to[i]), float&>) {
              add_gradient(from[i], to[i]);
            } else {
              for (int k = 0; k < to[i].length(); ++k) add_gradient(from[i][k], to[i][k]);
            }
          }
        });
      },
      gradient, sums);
}

void clear_sums(bool rest_too, Parameters<float>& sums) {
  Parameters<float> kept;
  kept.sh_degree = sums.sh_degree;
  kept.has_masks = sums.has_masks;
  if (!rest_too) {
    const std::size_t stride = sums.sh_stride();
    kept.sh = std::move(sums.sh);
    kept.resize(sums.size());
    for (std::size_t i = 0; i < kept.size(); ++i) kept.sh[i * stride] = glm::vec3(0);
  }
  sums = std::move(kept);
}

}  // namespace qs::cpu::train
