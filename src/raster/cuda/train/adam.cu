// SPDX-License-Identifier: MIT
#include "raster/cuda/train/adam.cuh"

namespace qs::cuda::train {
namespace {

/// Values of one kind of parameter, or of all colour coefficients, with their gradients and
/// moments. Kernels read and write four neighbours at once.
struct Values {
  float *values, *by, *first, *second;
  std::uint64_t size;
  std::uint64_t from;  ///< values below it have rate `rate`, the others rate `rest`
  float rate, rest;
};

struct StepInput {
  static constexpr unsigned kKinds = 5;
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
  const auto step = [&](std::uint64_t i, float gradient, float& value, float& first,
                        float& second) {
    adam(in.step, i < all.from ? all.rate : all.rest, gradient, value, first, second);
  };
  if (at + kNeighbours <= all.size) {
    const float4 by = *reinterpret_cast<const float4*>(all.by + at);
    float4 value = *reinterpret_cast<const float4*>(all.values + at);
    float4 first = *reinterpret_cast<const float4*>(all.first + at);
    float4 second = *reinterpret_cast<const float4*>(all.second + at);
    step(at, by.x, value.x, first.x, second.x);
    step(at + 1, by.y, value.y, first.y, second.y);
    step(at + 2, by.z, value.z, first.z, second.z);
    step(at + 3, by.w, value.w, first.w, second.w);
    *reinterpret_cast<float4*>(all.values + at) = value;
    *reinterpret_cast<float4*>(all.first + at) = first;
    *reinterpret_cast<float4*>(all.second + at) = second;
  } else {
    for (std::uint64_t k = at; k < all.size; ++k)
      step(k, all.by[k], all.values[k], all.first[k], all.second[k]);
  }
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
  const auto add = [&](auto member, unsigned width, double rate, std::uint64_t from, double rest) {
    const auto floats = [&](const ParametersView& view) {
      return reinterpret_cast<float*>(view.*member);
    };
    const std::uint64_t size = std::uint64_t{width} * values.count;
    in.kinds[kind] = {floats(values),
                      floats(by),
                      floats(first),
                      floats(second),
                      size,
                      from,
                      static_cast<float>(rate),
                      static_cast<float>(rest)};
    blocks += blocks_for((size + kNeighbours - 1) / kNeighbours);
    in.ends[kind++] = blocks;
  };
  const auto add_kind = [&](auto member, unsigned width, double rate) {
    add(member, width, rate, std::uint64_t{width} * values.count, rate);
  };
  add_kind(&ParametersView::means, 3, rates.mean);
  add_kind(&ParametersView::log_scales, 3, rates.log_scale);
  add_kind(&ParametersView::rotations, 4, rates.rotation);
  add_kind(&ParametersView::opacity_logits, 1, rates.opacity);
  const auto channels = 3 * static_cast<unsigned>(values.sh_coefficients);
  add(&ParametersView::sh, channels, rates.sh_dc, std::uint64_t{3} * values.count, rates.sh_rest);
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

}  // namespace qs::cuda::train
