// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/train/adam.cuh"

namespace qs::cuda::train {
namespace {

/// Values of one kind of parameter with their gradients and moments. Kernels read and write four
/// neighbours at once.
struct Values {
  float *values, *by, *first, *second;
  std::uint64_t size;
  float rate;
};

struct StepInput {
  static constexpr unsigned kKinds = 4;
  AdamStep step;
  Values kinds[kKinds];
  unsigned ends[kKinds];  ///< blocks up to and including the last block of each kind
};

constexpr unsigned kNeighbours = 4;

/// One thread per four values. The loads of a thread do not depend on each other.
__global__ void __launch_bounds__(kThreads) step_values(StepInput in) {
  unsigned kind = 0;
  while (blockIdx.x >= in.ends[kind]) ++kind;
  const unsigned block = blockIdx.x - (kind > 0 ? in.ends[kind - 1] : 0);
  const Values& all = in.kinds[kind];
  const std::uint64_t at = kNeighbours * (std::uint64_t{block} * kThreads + threadIdx.x);
  const auto step = [&](float gradient, float& value, float& first, float& second) {
    adam(in.step, all.rate, gradient, value, first, second);
  };
  if (at + kNeighbours <= all.size) {
    const float4 by = *reinterpret_cast<const float4*>(all.by + at);
    float4 value = *reinterpret_cast<const float4*>(all.values + at);
    float4 first = *reinterpret_cast<const float4*>(all.first + at);
    float4 second = *reinterpret_cast<const float4*>(all.second + at);
    step(by.x, value.x, first.x, second.x);
    step(by.y, value.y, first.y, second.y);
    step(by.z, value.z, first.z, second.z);
    step(by.w, value.w, first.w, second.w);
    *reinterpret_cast<float4*>(all.values + at) = value;
    *reinterpret_cast<float4*>(all.first + at) = first;
    *reinterpret_cast<float4*>(all.second + at) = second;
  } else {
    for (std::uint64_t k = at; k < all.size; ++k)
      step(all.by[k], all.values[k], all.first[k], all.second[k]);
  }
}

struct ColorStepInput {
  AdamStep step;
  float dc_rate, rest_rate;
  int sh_degree;  ///< of the gradients
  int moving;     ///< coefficients whose moments may not be zero
  const ColorGradient<float>* gradients;
  ParametersView values, first, second;
};

/// One thread per Gaussian. The loads of a coefficient do not depend on each other.
__global__ void __launch_bounds__(kThreads) step_colors(ColorStepInput in) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= in.values.count) return;
  const ColorGradient<float> gradient = in.gradients[i];
  const auto step = [&](int k, const glm::vec3& by) {
    glm::vec3 value = in.values.coefficient(i, k), first = in.first.coefficient(i, k),
              second = in.second.coefficient(i, k);
    const float rate = k == 0 ? in.dc_rate : in.rest_rate;
    for (int c = 0; c < 3; ++c) adam(in.step, rate, by[c], value[c], first[c], second[c]);
    in.values.set_coefficient(i, k, value);
    in.first.set_coefficient(i, k, first);
    in.second.set_coefficient(i, k, second);
  };
  sh_gradient<float>(
      in.sh_degree, gradient.direction, [](int) { return glm::vec3(0.0f); }, gradient.by_color,
      step);
  for (int k = sh_coefficient_count(in.sh_degree); k < in.moving; ++k) step(k, glm::vec3(0.0f));
}

/// Strategy mcmc, before the step. One thread per Gaussian.
__global__ void __launch_bounds__(kThreads)
    add_sparsity(Sparsity sparsity, ParametersView values, ParametersView by) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= values.count) return;
  sparsity.add_gradient(static_cast<double>(values.count), values.log_scales[i],
                        values.opacity_logits[i], by.log_scales[i], by.opacity_logits[i]);
}

/// Strategy mcmc, after the step. One thread per Gaussian.
__global__ void __launch_bounds__(kThreads) add_noise(Noise noise, ParametersView values) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= values.count) return;
  values.means[i] = noise.moved(i, values.means[i], values.log_scales[i], values.rotations[i],
                                values.opacity_logits[i]);
}

void step_all(const Rates& rates, const ParametersView& values, const ParametersView& by,
              AdamState& state, cudaStream_t stream) {
  StepInput in{};
  in.step = AdamStep::number(state.steps);
  const ParametersView first = state.first.view(), second = state.second.view();
  unsigned kind = 0, blocks = 0;
  const auto add = [&](auto member, unsigned width, double rate) {
    const auto floats = [&](const ParametersView& view) {
      return reinterpret_cast<float*>(view.*member);
    };
    const std::uint64_t size = std::uint64_t{width} * values.count;
    in.kinds[kind] = {floats(values), floats(by), floats(first),
                      floats(second), size,       static_cast<float>(rate)};
    blocks += blocks_for((size + kNeighbours - 1) / kNeighbours);
    in.ends[kind++] = blocks;
  };
  add(&ParametersView::means, 3, rates.mean);
  add(&ParametersView::log_scales, 3, rates.log_scale);
  add(&ParametersView::rotations, 4, rates.rotation);
  add(&ParametersView::opacity_logits, 1, rates.opacity);
  launch("take_step", step_values, blocks, stream, in);
}

}  // namespace

void take_step(const StepOrder& order, Parameters& parameters, Parameters& gradient,
               AdamState& state, cudaStream_t stream) {
  if (order.moves) ++state.steps;
  if (parameters.count == 0 || (!order.moves && !order.noise)) return;
  const unsigned blocks = blocks_for(parameters.count);
  if (order.moves) {
    if (order.sparsity) {
      launch("take_step", add_sparsity, blocks, stream, *order.sparsity, parameters.view(),
             gradient.view());
    }
    step_all(order.rates, parameters.view(), gradient.view(), state, stream);
  }
  if (order.noise) launch("take_step", add_noise, blocks, stream, *order.noise, parameters.view());
}

void take_color_step(const StepOrder& order, Parameters& parameters, const Gradients& gradients,
                     AdamState& state, cudaStream_t stream) {
  if (parameters.count == 0 || !order.moves) return;
  state.sh_degree = std::max(state.sh_degree, gradients.sh_degree);
  launch("take_step", step_colors, blocks_for(parameters.count), stream,
         ColorStepInput{AdamStep::number(state.steps), static_cast<float>(order.rates.sh_dc),
                        static_cast<float>(order.rates.sh_rest), gradients.sh_degree,
                        sh_coefficient_count(std::min(state.sh_degree, parameters.sh_degree)),
                        gradients.colors.data(), parameters.view(), state.first.view(),
                        state.second.view()});
}

}  // namespace qs::cuda::train
