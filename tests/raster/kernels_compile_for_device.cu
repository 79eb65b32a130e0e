// SPDX-License-Identifier: MIT
// Compile-only: uses every function of kernel/ once in device code, so that code which only g++
// accepts fails the build.
#include <array>
#include <tuple>

#include "raster/kernel/activation.h"
#include "raster/kernel/adam.h"
#include "raster/kernel/composite.h"
#include "raster/kernel/cull/modes.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/gradient/activation.h"
#include "raster/kernel/gradient/footprint.h"
#include "raster/kernel/gradient/pixel.h"
#include "raster/kernel/gradient/project.h"
#include "raster/kernel/gradient/sh.h"
#include "raster/kernel/random.h"
#include "raster/kernel/sh.h"

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

template <class Real>
__global__ void use_gradients(View<Real> view, const typename PixelMath<Real>::Splat* splats,
                              const glm::vec<3, Real>* points, const glm::qua<Real>* rotations,
                              GeometryGradient<Real>* geometry, ShapeGradient<Real>* shapes,
                              SplatGradient<Real>* sums, glm::vec<3, Real>* sh) {
  Real transmittance = 1, alpha = 0;
  if (composite(splats[0], Real(1), Real(2), transmittance, alpha) != Step::blends) return;
  PixelSums<Real> pixels;
  add_pixel<Real>(splats[0], 1, 2, alpha, transmittance, points[0], points[1], pixels);
  *sums = splat_gradient<Real>(splats[0], pixels);
  const Covariance3<Real> sigma = covariance_of(points[2], unit_rotation(rotations[0]));
  const Covariance2<Real> before = project_covariance(view, points[0], sigma);
  const Covariance2<Real> after{before.xx + 1, before.xy, before.yy + 1};
  Covariance2<Real> d = conic_gradient(after, sums->conic);
  d.xx += compensation_gradient(before, after, sums->opacity).xx;
  *geometry = project_covariance_gradient(view, points[0], sigma, d);
  geometry->mean += view_gradient(view, pixel_gradient(view, points[0], sums->mean_px));
  *shapes = covariance_gradient(points[2], rotations[0], geometry->covariance);
  const glm::vec<3, Real> d_color = clamp_gradient(splats[0].color, sums->color);
  geometry->mean += direction_gradient(
      points[3], sh_gradient(
                     3, points[3], [&](int i) { return points[i]; }, d_color,
                     [&](int i, const glm::vec<3, Real>& gradient) { sh[i] = gradient; }));
  sums->opacity = opacity_gradient(opacity_of(splats[0].opacity), sums->opacity);
}

__global__ void use_optimizer(AdamStep step, float* values) {
  adam(step, 0.1f, values[0], values[1], values[2], values[3]);
  values[4] = static_cast<float>(Random::of(1, RandomUse::noise, 2).normal3(threadIdx.x).x);
}

template __global__ void use_gradients<float>(View<float>, const Splat*, const glm::vec3*,
                                              const glm::quat*, GeometryGradient<float>*,
                                              ShapeGradient<float>*, SplatGradient<float>*,
                                              glm::vec3*);
template __global__ void use_gradients<double>(View<double>, const Splat64*, const glm::dvec3*,
                                               const glm::dquat*, GeometryGradient<double>*,
                                               ShapeGradient<double>*, SplatGradient<double>*,
                                               glm::dvec3*);

// Every mode of the table, by an array of the kernels' addresses.
template <class... P>
constexpr auto use_cullers(std::tuple<P...>) {
  return std::array{&use_culler<P>...};
}
[[maybe_unused]] const auto kUsedCullers = use_cullers(AllCullers());

}  // namespace qs
