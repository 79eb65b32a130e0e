// SPDX-License-Identifier: MIT
#include <algorithm>

#include "learn/diff/cuda/color_sums.cuh"
#include "learn/diff/cuda/sum_gaussians.cuh"
#include "learn/gradient/color_field.h"
#include "learn/step/cuda/backward.cuh"

namespace qs::cuda::train {
namespace {

template <unsigned kNumbers>
void launch_sums(const StepView& view, std::uint32_t count, const ForwardFrame& frame,
                 const void* pairs, void* sums) {
  diff::sum_pairs_of_gaussians<kNumbers>(
      {count, frame.first_places.data(), frame.tile_counts.data(), static_cast<const float*>(pairs),
       static_cast<float*>(sums)},
      view.stream);
}

struct GaussianInput {
  GradientRules<float> rules;
  ParametersView parameters;
  const std::uint32_t* tile_counts;  ///< 0: not visible
  const PixelSums<float>* sums;      ///< per Gaussian
  const ListedSplat* splats;
};

/// One thread per Gaussian. `d_outputs` is null without a colour field.
__global__ void __launch_bounds__(kThreads)
    gaussian_gradients(GaussianInput in, ParametersView out, ColorGradient<float>* colors,
                       glm::vec2* d_mean_px, glm::vec3* d_outputs) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= in.parameters.count) return;
  GaussianValues<float> gradient{glm::vec3(0.0f), glm::vec3(0.0f), glm::quat(0, 0, 0, 0), 0.0f,
                                 0.0f};
  glm::vec2 mean_px(0.0f);
  ColorGradient<float> color{glm::vec3(0.0f), glm::vec3(0.0f)};
  glm::vec3 d_output(0.0f);
  if (in.tile_counts[i] > 0) {
    SplatGradient<float> splat = splat_gradient<float>(in.splats[i].splat, in.sums[i]);
    if (d_outputs != nullptr) {
      d_output = output_gradient(in.splats[i].splat.color, splat.color);
      splat.color = glm::vec3(0.0f);
    }
    const GaussianValues<float> gaussian = in.parameters.gaussian(i);
    const auto coefficient = [&](int k) { return in.parameters.coefficient(i, k); };
    color = ColorGradient<float>::of(in.rules, gaussian.mean, coefficient, splat.color);
    gradient = gaussian_gradient<float>(in.rules, gaussian, coefficient, splat, color,
                                        [](int, const glm::vec3&) {});
    mean_px = splat.mean_px;
  }
  out.set_gaussian(i, gradient);
  colors[i] = color;
  d_mean_px[i] = mean_px;
  if (d_outputs != nullptr) d_outputs[i] = d_output;
}

/// One thread per Gaussian.
__global__ void __launch_bounds__(kThreads)
    expand_color_gradients(int sh_degree, const ColorGradient<float>* colors, ParametersView out) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= out.count) return;
  for (int k = 0; k < out.sh_coefficients; ++k) out.set_coefficient(i, k, glm::vec3(0.0f));
  sh_gradient<float>(
      sh_degree, colors[i].direction, [](int) { return glm::vec3(0.0f); }, colors[i].by_color,
      [&](int k, const glm::vec3& by) { out.set_coefficient(i, k, by); });
}

void sum_pairs_of_tiles(const StepView& view, const ForwardFrame& frame, const glm::vec3* d_color,
                        bool absolute, BackwardScratch& scratch) {
  if (frame.pairs.count == 0) return;
  scratch.pairs.reserve("the step's pairs", frame.pairs.room());
  if (absolute) scratch.absolute.reserve("the step's pairs", frame.pairs.room());
  using diff::TrainedDerivatives;
  launch("sum_pairs",
         absolute ? diff::sum_pairs<true, TrainedDerivatives>
                  : diff::sum_pairs<false, TrainedDerivatives>,
         Blocks(frame.segments, kTilePixels), view.stream,
         diff::PairInput<TrainedDerivatives>{frame.tiles(view),
                                             frame.segment_tiles.data(),
                                             frame.states.data(),
                                             frame.color.data(),
                                             frame.last.data(),
                                             {d_color}},
         diff::PairSums{scratch.pairs.data(), scratch.absolute.data(), nullptr});
}

}  // namespace

void backward(const StepView& view, const ParametersView& parameters, ForwardFrame& frame,
              const glm::vec3* d_color, const qs::train::BackwardOrder& order,
              BackwardScratch& scratch, Gradients& gradients, glm::vec3* d_outputs) {
  gradients.by.resize_shapes(parameters.count, parameters.has_masks());
  gradients.colors.reserve("the gradients", with_room(parameters.count));
  gradients.mean_px.reserve("the gradients", with_room(parameters.count));
  gradients.has_absolute = order.absolute;
  if (order.absolute) gradients.absolute_px.reserve("the gradients", with_room(parameters.count));
  scratch.sums.reserve("the gradients", with_room(parameters.count));
  if (parameters.count == 0) return;
  view.throw_if_cancelled();
  sum_pairs_of_tiles(view, frame, d_color, order.absolute, scratch);
  gradients.sh_degree = std::min(view.settings.sh_degree, parameters.sh_degree);
  const GradientRules<float> rules{make_view<float>(view.camera), view.settings.dilation,
                                   view.antialiased(), gradients.sh_degree};
  const GaussianInput in{rules, parameters, frame.tile_counts.data(), scratch.sums.data(),
                         frame.splats.data()};
  launch_sums<diff::kSums>(view, parameters.count, frame, scratch.pairs.data(),
                           scratch.sums.data());
  if (order.absolute) {
    launch_sums<2>(view, parameters.count, frame, scratch.absolute.data(),
                   gradients.absolute_px.data());
  }
  launch("gaussian_gradients", gaussian_gradients, blocks_for(parameters.count), view.stream, in,
         gradients.by.view(), gradients.colors.data(), gradients.mean_px.data(), d_outputs);
}

void expand_colors(int sh_degree, cudaStream_t stream, Gradients& gradients) {
  gradients.by.resize(gradients.by.count, sh_degree, gradients.by.has_masks);
  if (gradients.by.count == 0) return;
  launch("expand_colors", expand_color_gradients, blocks_for(gradients.by.count), stream,
         gradients.sh_degree, gradients.colors.data(), gradients.by.view());
}

}  // namespace qs::cuda::train
