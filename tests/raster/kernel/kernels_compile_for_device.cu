// SPDX-License-Identifier: MIT
// Compile-only: uses every function of kernel/ once in device code, so that code which only g++
// accepts fails the build.
#include <array>
#include <tuple>

#include "learn/gradient/adam.h"
#include "learn/gradient/color_field.h"
#include "learn/gradient/density.h"
#include "learn/gradient/gaussian.h"
#include "learn/gradient/integer_sum.h"
#include "learn/gradient/loss.h"
#include "learn/gradient/residual_codes.h"
#include "raster/kernel/activation.h"
#include "raster/kernel/color_field.h"
#include "raster/kernel/composite.h"
#include "raster/kernel/cull/modes.h"
#include "raster/kernel/depth.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/frustum.h"
#include "raster/kernel/half.h"
#include "raster/kernel/nearest_code.h"
#include "raster/kernel/random.h"
#include "raster/kernel/sh.h"
#include "raster/kernel/ssim.h"

namespace qs {

template <class P>
__global__ void use_culler(View<float> view, FootprintRules rules, const ActiveGaussian* gaussians,
                           TileGrid grid, unsigned* counts, int* tiles) {
  Projected projected;
  if (!project(view, rules, gaussians[threadIdx.x], projected)) return;
  counts[threadIdx.x] = count_tiles<P>(projected.footprint, grid);
  for_each_tile<P>(projected.footprint, grid, [&](int tile) { *tiles++ = tile; });
}

__global__ void use_sh(int degree, const glm::vec3* coefficients, glm::vec3* colors) {
  colors[0] = sh_color<float>(degree, glm::vec3(0, 0, 1), [&](int i) { return coefficients[i]; });
}

__global__ void use_frustum(View<float> view, FootprintRules rules, TileGrid grid,
                            BlockBounds* bounds, bool* missed) {
  bounds[0].include(glm::vec3(1), {1, 0, 0, 1, 0, 1});
  missed[0] = Frustum(view, rules, grid).misses(bounds[0]);
}

__global__ void use_half(const float* values, std::uint16_t* halves, float* back) {
  if (to_half(values[0], halves[0])) back[0] = float_of_half(halves[0]);
  back[1] = float_of_any_half(round_to_half(values[1]));
}

__global__ void use_color_field(GridLevel level, const glm::vec3* means, std::uint32_t* entries,
                                float* features, float* basis) {
  const glm::vec3 place = level.scale * contract(means[0]) + 0.5f;
  entries[0] = grid_entry(level, static_cast<std::uint32_t>(place.x), 1, 2);
  encode_direction(means[1], features);
  sh_basis(means[1], basis);
  for_each_vertex(level, contract(means[2]), [&](std::size_t entry, float weight) {
    features[0] += weight * color_of_output(features[entry]);
  });
  entries[1] = static_cast<std::uint32_t>(field_gaussian(1, field_block_size(2)));
}

__global__ void use_sums_and_codes(const float* codes, glm::vec3* scales, glm::quat* rotations,
                                   std::int64_t* sums, float* values) {
  scale_vector(scales[0], values);
  sums[0] = sum_units(values[0]) + nearest_code(codes, 64, kScaleValues, values);
  scales[0] = coded_log_scale(values);
  rotation_vector(rotations[0], values);
  move_code(AdamStep{1, 1}, code_gradient(values[0], 3), values[1], values[2], values[3]);
  scales[1] = coded_scale_gradient(scales[0], scales[1], scales[2]);
  rotations[1] = coded_rotation_gradient(rotations[0], rotations[1]);
  scales[2] = output_gradient(scales[0], scales[1]);
}

template <class Real>
__global__ void use_gradients(GradientRules<Real> rules,
                              const typename PixelMath<Real>::Splat* splats,
                              const GaussianValues<Real>* gaussians,
                              const glm::vec<3, Real>* pixels, GaussianValues<Real>* gradients,
                              glm::vec<3, Real>* sh) {
  Real transmittance = 1, alpha = 0;
  if (composite(splats[0], Real(1), Real(2), transmittance, alpha) != Step::blends) return;
  PixelSums<Real> sums;
  add_pixel<Real>(splats[0], {1, 2, alpha, transmittance, pixels[0], pixels[1]}, sums);
  gradients[0] = gaussian_gradient<Real>(
      rules, gaussians[0], [&](int i) { return pixels[i]; }, splat_gradient<Real>(splats[0], sums),
      [&](int i, const glm::vec<3, Real>& gradient) { sh[i] = gradient; });
}

__global__ void use_depth(PixelDepth<float> pixel, float* values) {
  pixel.add(values[0], values[1], values[2]);
  values[0] = pixel.alpha() + pixel.expected() + pixel.median;
}

__global__ void use_activation(const GaussianValues<double>* gaussians, ActiveGaussian* active) {
  const GaussianValues<double>& g = gaussians[0];
  *active =
      active_gaussian(glm::vec3(g.mean), covariance_of(g.log_scale, unit_rotation(g.rotation)),
                      opacity_of(g.opacity_logit));
}

__global__ void use_mcmc(Sparsity sparsity, Noise noise, GaussianValues<float>* gaussians) {
  GaussianValues<float>& g = gaussians[0];
  sparsity.add_gradient(2, g.log_scale, g.opacity_logit, gaussians[1].log_scale,
                        gaussians[1].opacity_logit);
  g.mean = noise.moved(0, g.mean, g.log_scale, g.rotation, g.opacity_logit);
}

template <class Real>
__global__ void use_loss(LossGradient<Real> gradient, Real* values) {
  const auto s = Similarity<Real>::of(values[0], values[1], values[2], values[3], values[4]);
  values[5] = gradient.by(values[0], values[1], s.by_a, s.by_aa, s.by_ab);
}
template __global__ void use_loss<float>(LossGradient<float>, float*);
template __global__ void use_loss<double>(LossGradient<double>, double*);

__global__ void use_photograph(const std::uint8_t* rgb, glm::vec3* color) {
  *color = photograph_color(rgb) + background_behind(rgb[3], *color);
}

__global__ void use_optimizer(AdamStep step, float* values) {
  adam(step, 0.1f, values[0], values[1], values[2], values[3]);
  add_movement(glm::vec2(1), glm::vec2(2), values[5]);
  values[4] = static_cast<float>(Random::of(1, RandomUse::noise, 2).normal3(threadIdx.x).x);
}

template __global__ void use_gradients<float>(GradientRules<float>, const Splat*,
                                              const GaussianValues<float>*, const glm::vec3*,
                                              GaussianValues<float>*, glm::vec3*);
template __global__ void use_gradients<double>(GradientRules<double>, const SplatOf<double>*,
                                               const GaussianValues<double>*, const glm::dvec3*,
                                               GaussianValues<double>*, glm::dvec3*);

// Every mode of the table, by an array of the kernels' addresses.
template <class... P>
constexpr auto use_cullers(std::tuple<P...>) {
  return std::array{&use_culler<P>...};
}
[[maybe_unused]] const auto kUsedCullers = use_cullers(AllCullers());

}  // namespace qs
