// SPDX-License-Identifier: MIT
#include <algorithm>

#include "learn/step/cuda/adam.cuh"

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
  static constexpr unsigned kKinds = 5;
  AdamStep step;
  Values kinds[kKinds];
  unsigned ends[kKinds];  ///< blocks up to and including the last block of each kind
};

/// One thread per four values. The loads of a thread do not depend on each other.
__global__ void __launch_bounds__(kThreads) step_values(StepInput in) {
  unsigned kind = 0;
  while (blockIdx.x >= in.ends[kind]) ++kind;
  const unsigned block = blockIdx.x - (kind > 0 ? in.ends[kind - 1] : 0);
  const Values& all = in.kinds[kind];
  const std::uint64_t at = kNeighbours * (std::uint64_t{block} * kThreads + threadIdx.x);
  if (at + kNeighbours <= all.size) {
    const auto by = Neighbours::load(all.by + at);
    auto value = Neighbours::load(all.values + at);
    auto first = Neighbours::load(all.first + at), second = Neighbours::load(all.second + at);
    step_neighbours(in.step, all.rate, by, value, first, second);
    value.store(all.values + at);
    first.store(all.first + at);
    second.store(all.second + at);
  } else {
    for (std::uint64_t k = at; k < all.size; ++k)
      adam(in.step, all.rate, all.by[k], all.values[k], all.first[k], all.second[k]);
  }
}

struct ColorStepInput {
  AdamStep step, rest_step;  ///< the steps of DC and of the other coefficients
  float dc_rate, rest_rate;
  int sh_degree;         ///< SH degree of the gradients
  unsigned row_blocks;   ///< that step a coefficient
  unsigned coefficient;  ///< the first coefficient
  const ColorGradient<float>* gradients;
  const float* sums;  ///< sums of derivatives, by row, instead of the gradients
  ParametersView values, first, second;
};

struct ColorSumInput {
  int sh_degree;
  unsigned row_blocks, coefficient;
  const ColorGradient<float>* gradients;
  ParametersView sums;
};

/// The derivative of the colour by a coefficient, without the clamp.
__device__ float basis_of(int sh_degree, int coefficient, const glm::vec3& direction) {
  float basis = 0;
  sh_gradient<float>(
      sh_degree, direction, [](int) { return glm::vec3(0.0f); }, glm::vec3(1.0f),
      [&](int k, const glm::vec3& by) {
        if (k == coefficient) basis = by.x;
      });
  return basis;
}

/// kSummed: uses in.sums. One thread per coefficient of four Gaussians. Rows have room for all
/// four. The loads of a thread do not depend on each other.
template <bool kSummed>
__global__ void __launch_bounds__(kThreads) step_colors(ColorStepInput in) {
  const unsigned coefficient = in.coefficient + blockIdx.x / in.row_blocks;
  const std::uint32_t first_gaussian =
      kNeighbours * (blockIdx.x % in.row_blocks * kThreads + threadIdx.x);
  if (first_gaussian >= in.values.count) return;
  Neighbours value[3], first[3], second[3];
#pragma unroll
  for (unsigned c = 0; c < 3; ++c) {
    const std::size_t at = (3 * coefficient + c) * std::size_t{in.values.sh_row} + first_gaussian;
    value[c] = Neighbours::load(in.values.sh + at);
    first[c] = Neighbours::load(in.first.sh + at);
    second[c] = Neighbours::load(in.second.sh + at);
  }
  const float rate = coefficient == 0 ? in.dc_rate : in.rest_rate;
  const AdamStep adam_step = coefficient == 0 ? in.step : in.rest_step;
#pragma unroll
  for (unsigned n = 0; n < kNeighbours; ++n) {
    if (first_gaussian + n >= in.values.count) break;
    glm::vec3 by;
    if constexpr (kSummed) {
      for (unsigned c = 0; c < 3; ++c)
        by[static_cast<int>(c)] =
            in.sums[(3 * coefficient + c) * std::size_t{in.values.sh_row} + first_gaussian + n];
    } else {
      const ColorGradient<float> gradient = in.gradients[first_gaussian + n];
      by = basis_of(in.sh_degree, static_cast<int>(coefficient), gradient.direction) *
           gradient.by_color;
    }
#pragma unroll
    for (unsigned c = 0; c < 3; ++c)
      adam(adam_step, rate, by[static_cast<int>(c)], value[c][n], first[c][n], second[c][n]);
  }
#pragma unroll
  for (unsigned c = 0; c < 3; ++c) {
    const std::size_t at = (3 * coefficient + c) * std::size_t{in.values.sh_row} + first_gaussian;
    value[c].store(in.values.sh + at);
    first[c].store(in.first.sh + at);
    second[c].store(in.second.sh + at);
  }
}

/// One thread per coefficient of a Gaussian.
__global__ void __launch_bounds__(kThreads) sum_colors(ColorSumInput in) {
  const unsigned coefficient = in.coefficient + blockIdx.x / in.row_blocks;
  const std::uint32_t i = blockIdx.x % in.row_blocks * kThreads + threadIdx.x;
  if (i >= in.sums.count) return;
  const ColorGradient<float> gradient = in.gradients[i];
  const int k = static_cast<int>(coefficient);
  const glm::vec3 by = basis_of(in.sh_degree, k, gradient.direction) * gradient.by_color;
  glm::vec3 sum = in.sums.coefficient(i, k);
  for (int c = 0; c < 3; ++c) add_gradient(by[c], sum[c]);
  in.sums.set_coefficient(i, k, sum);
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
  if (values.mask_logits != nullptr) add(&ParametersView::mask_logits, 1, rates.mask);
  launch("take_step", step_values, blocks, stream, in);
}

}  // namespace

void take_step(const StepOrder& order, Parameters& parameters, Parameters& gradient,
               AdamState& state, cudaStream_t stream) {
  if (order.moves) {
    ++state.steps;
    if (!(order.sums && order.rest_waits)) ++state.rest_steps;
  }
  if (parameters.count == 0) return;
  const ParametersView values = parameters.view(), by = gradient.view();
  const auto for_each = [&](const auto& work) {
    for_each_item("take_step", values.count, stream, work);
  };
  const auto count = static_cast<double>(values.count);
  if (order.moves && order.sparsity) {
    for_each([=, sparsity = *order.sparsity] __device__(std::uint32_t i) {
      sparsity.add_gradient(count, values.log_scales[i], values.opacity_logits[i], by.log_scales[i],
                            by.opacity_logits[i]);
    });
  }
  if (order.moves && parameters.has_masks) {  // the share of the mean mask in the loss
    for_each([=, weight = order.mask_weight] __device__(std::uint32_t i) {
      by.mask_logits[i] += mask_weight_gradient(weight, count, values.mask_logits[i]);
    });
  }
  if (order.moves) step_all(order.rates, values, by, state, stream);
  if (order.noise) {
    for_each([=, noise = *order.noise] __device__(std::uint32_t i) {
      values.means[i] = noise.moved(i, values.means[i], values.log_scales[i], values.rotations[i],
                                    values.opacity_logits[i]);
    });
  }
}

void take_color_step(const StepOrder& order, Parameters& parameters, const Gradients& gradients,
                     GradientSums& sums, AdamState& state, cudaStream_t stream) {
  if (parameters.count == 0 || !order.moves) return;
  state.sh_degree = std::max(state.sh_degree, gradients.sh_degree);
  const unsigned moving =
      static_cast<unsigned>(sh_coefficient_count(std::min(state.sh_degree, parameters.sh_degree)));
  const unsigned blocks = blocks_for((parameters.count + kNeighbours - 1) / kNeighbours);
  const auto step = [&](unsigned first, unsigned end, const float* summed) {
    if (first == end) return;
    launch("step_colors", summed != nullptr ? step_colors<true> : step_colors<false>,
           blocks * (end - first), stream,
           ColorStepInput{AdamStep::number(state.steps),
                          AdamStep::number(std::max<std::uint64_t>(state.rest_steps, 1)),
                          static_cast<float>(order.rates.sh_dc),
                          static_cast<float>(order.rates.sh_rest), gradients.sh_degree, blocks,
                          first, gradients.colors.data(), summed, parameters.view(),
                          state.first.view(), state.second.view()});
  };
  if (!order.sums) {
    step(0, moving, nullptr);
    return;
  }
  step(0, 1, sums.has_others ? sums.by.sh.data() : nullptr);
  sums.has_others = false;
  if (order.rest_waits) return;
  step(1, moving, sums.has_rest ? sums.by.sh.data() : nullptr);
  sums.has_rest = false;
}

void add_gradients(const StepOrder& order, Gradients& gradients, GradientSums& sums,
                   cudaStream_t stream) {
  if (order.moves && !sums.has_others) return;
  for_each_item("add_gradients", gradients.by.count, stream,
                [by = gradients.by.view(), all = sums.by.view(),
                 fresh = !sums.has_others] __device__(std::uint32_t i) {
                  const GaussianValues<float> gradient = by.gaussian(i);
                  GaussianValues<float> sum =
                      fresh ? GaussianValues<float>::zero() : all.gaussian(i);
                  for (int k = 0; k < 3; ++k) {
                    add_gradient(gradient.mean[k], sum.mean[k]);
                    add_gradient(gradient.log_scale[k], sum.log_scale[k]);
                  }
                  for (int k = 0; k < 4; ++k) add_gradient(gradient.rotation[k], sum.rotation[k]);
                  add_gradient(gradient.opacity_logit, sum.opacity_logit);
                  add_gradient(gradient.mask_logit, sum.mask_logit);
                  all.set_gaussian(i, sum);
                });
}

void add_color_gradients(const StepOrder& order, const Gradients& gradients, GradientSums& sums,
                         cudaStream_t stream) {
  if (gradients.by.count == 0) return;
  const ParametersView by = sums.by.view();
  const unsigned blocks = blocks_for(by.count);
  const auto add = [&](unsigned first, unsigned end, unsigned all, bool& has) {
    if (!has) {
      const std::size_t row = std::size_t{3} * by.sh_row;
      set_zero("add gradients", by.sh + first * row, (all - first) * row, stream);
    }
    has = true;
    if (first == end) return;
    launch("add_gradients", sum_colors, blocks * (end - first), stream,
           ColorSumInput{gradients.sh_degree, blocks, first, gradients.colors.data(), by});
  };
  const auto used = static_cast<unsigned>(sh_coefficient_count(gradients.sh_degree));
  const auto all = static_cast<unsigned>(by.sh_coefficients);
  if (!order.moves || sums.has_others) add(0, 1, 1, sums.has_others);
  if (!order.moves || order.rest_waits || sums.has_rest) add(1, used, all, sums.has_rest);
}

}  // namespace qs::cuda::train
