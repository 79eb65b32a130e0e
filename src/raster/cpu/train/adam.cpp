// SPDX-License-Identifier: MIT
#include "raster/cpu/train/adam.h"

namespace qs::cpu::train {

void take_step(Parameters<float>& parameters, const Parameters<float>& gradient, const Rates& rates,
               AdamState& state, ThreadPool& pool) {
  const AdamStep step = AdamStep::number(++state.steps);
  const std::size_t stride = parameters.sh_stride();
  // Steps `count` values of Gaussian i, whose first one of each array `first` returns.
  const auto values = [&](double rate, int count, float* value, const float* by, float* first,
                          float* second) {
    for (int k = 0; k < count; ++k)
      adam(step, static_cast<float>(rate), by[k], value[k], first[k], second[k]);
  };
  pool.for_chunks(parameters.size(), 1024, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto vector = [&](double rate, int count, auto array, std::size_t at) {
        values(rate, count, &(parameters.*array)[at][0], &(gradient.*array)[at][0],
               &(state.first.*array)[at][0], &(state.second.*array)[at][0]);
      };
      using P = Parameters<float>;
      vector(rates.mean, 3, &P::means, i);
      vector(rates.log_scale, 3, &P::log_scales, i);
      vector(rates.rotation, 4, &P::rotations, i);
      values(rates.opacity, 1, &parameters.opacity_logits[i], &gradient.opacity_logits[i],
             &state.first.opacity_logits[i], &state.second.opacity_logits[i]);
      vector(rates.sh_dc, 3, &P::sh, i * stride);
      for (std::size_t k = 1; k < stride; ++k) vector(rates.sh_rest, 3, &P::sh, i * stride + k);
    }
  });
}

}  // namespace qs::cpu::train
