// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>

#include "learn/gradient/density.h"
#include "learn/step/cpu/passes.h"

namespace qs::cpu::train {
namespace {

// The numbers of an array of numbers, vectors or quaternions.
float* numbers(auto& array) { return reinterpret_cast<float*>(array.data()); }
const float* numbers(const auto& array) { return reinterpret_cast<const float*>(array.data()); }

template <class Array>
constexpr std::size_t kNumbers = sizeof(typename Array::value_type) / sizeof(float);

}  // namespace

void take_step(Parameters<float>& parameters, const Parameters<float>& gradient, const Rates& rates,
               AdamState& state, ThreadPool& pool, bool moves_rest) {
  const AdamStep step_of_most = AdamStep::number(++state.steps);
  if (moves_rest) ++state.rest_steps;
  const AdamStep step_of_rest = moves_rest ? AdamStep::number(state.rest_steps) : AdamStep{};
  const double kinds[] = {rates.mean,    rates.log_scale, rates.rotation,
                          rates.opacity, rates.sh_dc,     rates.mask};
  const double* next_rate = kinds;
  const auto step_array = [&]<class Array>(std::size_t values, Array& value, const Array& by,
                                           Array& first, Array& second) {
    constexpr std::size_t kWidth = kNumbers<Array>;
    const std::size_t moved = moves_rest ? values : std::min<std::size_t>(values, 1);
    const double rate = *next_rate++;
    pool.for_each(parameters.size(), 1024, [&](std::size_t i) {
      for (std::size_t k = 0; k < moved * kWidth; ++k) {
        const bool is_rest = k >= kWidth;
        const std::size_t at = i * values * kWidth + k;
        adam(is_rest ? step_of_rest : step_of_most,
             static_cast<float>(is_rest ? rates.sh_rest : rate), numbers(by)[at],
             numbers(value)[at], numbers(first)[at], numbers(second)[at]);
      }
    });
  };
  qs::train::for_each_array(step_array, parameters, gradient, state.first, state.second);
}

void add_gradients(const Parameters<float>& gradient, ThreadPool& pool, Parameters<float>& sums) {
  sums.resize_like(gradient);
  const auto add_array = [&]<class Array>(std::size_t, const Array& from, Array& to) {
    pool.for_each(from.size() * kNumbers<Array>, 4096,
                  [&](std::size_t k) { add_gradient(numbers(from)[k], numbers(to)[k]); });
  };
  qs::train::for_each_array(add_array, gradient, sums);
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

void add_view(const Gradients<float>& gradients, std::span<const std::uint8_t> counted, int width,
              int height, DensityStatistics& statistics) {
  const glm::vec2 half(0.5f * static_cast<float>(width), 0.5f * static_cast<float>(height));
  const bool absolute = !gradients.absolute_px.empty();
  if (absolute) statistics.absolute.resize(statistics.sums.size());
  for (std::size_t i = 0; i < statistics.sums.size(); ++i) {
    if (counted[i] == 0) continue;
    add_movement(half, gradients.mean_px[i], statistics.sums[i]);
    if (absolute) add_movement(half, gradients.absolute_px[i], statistics.absolute[i]);
    ++statistics.views[i];
  }
}

}  // namespace qs::cpu::train
