// SPDX-License-Identifier: MIT
#include <algorithm>

#include "learn/diff/cuda/color_sums.cuh"
#include "learn/diff/cuda/sums.cuh"
#include "learn/gradient/color_field.h"
#include "learn/step/cuda/forward.cuh"

namespace qs::cuda::train {
namespace {

void sum_pairs_of_tiles(const StepView& view, const ForwardFrame& frame, const glm::vec3* d_color,
                        bool absolute, BackwardScratch& scratch) {
  if (frame.pairs == 0) return;
  scratch.pairs.reserve("the step's pairs", frame.listed.sizes.pairs);
  if (absolute) scratch.absolute.reserve("the step's pairs", frame.listed.sizes.pairs);
  using diff::TrainedDerivatives;
  launch("sum_pairs",
         absolute ? diff::sum_pairs<true, TrainedDerivatives>
                  : diff::sum_pairs<false, TrainedDerivatives>,
         Blocks(frame.segments, kTilePixels), view.stream,
         diff::PairInput<TrainedDerivatives>(frame.listed, frame.pixels, {d_color}),
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
  const diff::GpuGaussianBlock& gaussians = frame.listed.gaussians;
  diff::sum_pairs_of_gaussians<diff::kSums>(gaussians, parameters.count, scratch.pairs.data(),
                                            scratch.sums.data(), view.stream);
  if (order.absolute)
    diff::sum_pairs_of_gaussians<2>(gaussians, parameters.count, scratch.absolute.data(),
                                    gradients.absolute_px.data(), view.stream);
  for_each_item(
      "gaussian_gradients", parameters.count, view.stream,
      [=, tile_counts = gaussians.tile_counts, sums = scratch.sums.data(),
       splats = gaussians.splats, out = gradients.by.view(), colors = gradients.colors.data(),
       d_mean_px = gradients.mean_px.data()] __device__(std::uint32_t i) {
        auto gradient = GaussianValues<float>::zero();
        glm::vec2 mean_px(0.0f);
        ColorGradient<float> color{glm::vec3(0.0f), glm::vec3(0.0f)};
        glm::vec3 d_output(0.0f);
        if (tile_counts[i] > 0) {
          SplatGradient<float> splat = splat_gradient<float>(splats[i].splat, sums[i]);
          if (d_outputs != nullptr) {
            d_output = output_gradient(splats[i].splat.color, splat.color);
            splat.color = glm::vec3(0.0f);
          }
          const GaussianValues<float> gaussian = parameters.gaussian(i);
          const auto coefficient = [&](int k) { return parameters.coefficient(i, k); };
          color = ColorGradient<float>::of(rules, gaussian.mean, coefficient, splat.color);
          gradient = gaussian_gradient<float>(rules, gaussian, coefficient, splat, color,
                                              [](int, const glm::vec3&) {});
          mean_px = splat.mean_px;
        }
        out.set_gaussian(i, gradient);
        colors[i] = color;
        d_mean_px[i] = mean_px;
        if (d_outputs != nullptr) d_outputs[i] = d_output;
      });
}

void expand_colors(int sh_degree, cudaStream_t stream, Gradients& gradients) {
  gradients.by.resize(gradients.by.count, sh_degree, gradients.by.has_masks);
  for_each_item("expand_colors", gradients.by.count, stream,
                [degree = gradients.sh_degree, colors = gradients.colors.data(),
                 out = gradients.by.view()] __device__(std::uint32_t i) {
                  for (int k = 0; k < out.sh_coefficients; ++k)
                    out.set_coefficient(i, k, glm::vec3(0.0f));
                  sh_gradient<float>(
                      degree, colors[i].direction, [](int) { return glm::vec3(0.0f); },
                      colors[i].by_color,
                      [&](int k, const glm::vec3& by) { out.set_coefficient(i, k, by); });
                });
}

}  // namespace qs::cuda::train
