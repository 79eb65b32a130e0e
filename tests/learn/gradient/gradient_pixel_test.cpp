// SPDX-License-Identifier: MIT
// The gradient of a pixel by the values of its Gaussians.
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "learn/gradient/pixel.h"
#include "raster/kernel/composite.h"
#include "support/differences.h"
#include "support/gradient_arguments.h"

namespace qs {
namespace {

using test::append;
using test::Draws;
using test::expect_gradient;
using test::kDraws;
using test::rounded;
using test::vec3;

constexpr std::size_t kSplatValues = 9;  // mean 2, conic 3, opacity, colour 3

template <class Real>
typename PixelMath<Real>::Splat splat_of(const std::vector<Real>& x, std::size_t i) {
  const Real* v = &x[i * kSplatValues];
  const Real k = static_cast<Real>(-0.5 * kLog2E);
  return {{v[0], v[1]}, {k * v[2], 2 * k * v[3], k * v[4]}, v[5], {v[6], v[7], v[8]}};
}

constexpr double kPixelX = 3, kPixelY = 5;

/// The colour of a pixel over the background, its parts, and the transmittance behind them.
template <class Real>
struct PixelWalk {
  struct Part {
    Real alpha, in_front;
    glm::vec<3, Real> upto;
    Step step;
  };
  glm::vec<3, Real> color{0};
  Real transmittance = 1;
  std::vector<Part> parts;

  PixelWalk(const std::vector<Real>& x, const glm::vec<3, Real>& background) {
    for (std::size_t i = 0; i < x.size() / kSplatValues; ++i) {
      const auto splat = splat_of(x, i);
      Part part{0, transmittance, color, Step::stops};
      part.step = composite(splat, Real(kPixelX), Real(kPixelY), transmittance, part.alpha);
      if (part.step == Step::blends) color += part.alpha * part.in_front * splat.color;
      part.upto = color;
      parts.push_back(part);
      if (part.step == Step::stops) break;
    }
    color += transmittance * background;
  }
};

template <class Real>
std::vector<Real> pixel_gradients(const std::vector<Real>& x, const glm::dvec3& background,
                                  const glm::dvec3& d_pixel) {
  const PixelWalk<Real> walk(x, glm::vec<3, Real>(background));
  std::vector<Real> result(x.size(), 0);
  for (std::size_t i = 0; i < walk.parts.size(); ++i) {
    const auto& part = walk.parts[i];
    if (part.step != Step::blends) continue;
    PixelSums<Real> sums;
    const BlendedPixel<Real> pixel{
        static_cast<Real>(kPixelX), static_cast<Real>(kPixelY), part.alpha, part.in_front,
        walk.color - part.upto,     glm::vec<3, Real>(d_pixel)};
    add_pixel<Real>(splat_of(x, i), pixel, sums);
    const SplatGradient<Real> sum = splat_gradient<Real>(splat_of(x, i), sums);
    const Real values[] = {sum.mean_px.x, sum.mean_px.y, sum.conic.x, sum.conic.y, sum.conic.z,
                           sum.opacity,   sum.color.x,   sum.color.y, sum.color.z};
    std::copy(std::begin(values), std::end(values), &result[i * kSplatValues]);
  }
  return result;
}

std::vector<double> random_splats(Draws& draws, std::size_t count, double opacity) {
  std::vector<double> x;
  for (std::size_t i = 0; i < count; ++i) {
    append(x, {kPixelX + draws.uniform(-2, 2), kPixelY + draws.uniform(-2, 2),
               draws.uniform(0.1, 0.3), draws.uniform(-0.05, 0.05), draws.uniform(0.1, 0.3),
               draws.uniform(0.3 * opacity, opacity), draws.uniform(0, 1), draws.uniform(0, 1),
               draws.uniform(0, 1)});
  }
  return x;
}

TEST(Gradient, of_a_pixel_equals_differences_for_every_value_of_its_gaussians) {
  Draws draws(1);
  const glm::dvec3 background(0.2, 0.9, 0.4);
  for (int draw = 0; draw < kDraws; ++draw) {
    const std::vector<double> x = random_splats(draws, 6, 0.8);
    const glm::dvec3 d_pixel = vec3(draws.uniform(3, -1, 1));
    for (const auto& part : PixelWalk<double>(x, background).parts)
      ASSERT_EQ(part.step, Step::blends) << "the draw is away from the kinks";
    expect_gradient(
        [&](const auto& at) { return glm::dot(PixelWalk<double>(at, background).color, d_pixel); },
        x, [&](const auto& at) { return pixel_gradients(at, background, d_pixel); });
  }
}

TEST(Gradient, passes_through_the_clamp_of_alpha) {
  // The clamped pixel has the gradient of a Gaussian whose alpha is 0.99 plus the unclamped change.
  std::vector<double> x = {kPixelX + 0.05, kPixelY, 0.2, 0, 0.2, 1.0, 0.3, 0.6, 0.9};
  const glm::dvec3 background(0), d_pixel(1, -2, 0.5);
  const double unclamped = std::exp(-0.5 * 0.2 * 0.05 * 0.05);
  ASSERT_GT(unclamped, 0.99);
  const double color = 0.3 - 2 * 0.6 + 0.5 * 0.9;
  const std::vector<double> expected = {color * unclamped * 0.2 * -0.05,
                                        0,
                                        color * unclamped * -0.5 * 0.05 * 0.05,
                                        0,
                                        0,
                                        color * unclamped,
                                        0.99 * 1,
                                        0.99 * -2,
                                        0.99 * 0.5};
  test::expect_close(pixel_gradients(x, background, d_pixel), expected, 1e-12);
  test::expect_close(pixel_gradients(rounded<float>(x), background, d_pixel), expected, 1e-5);
}

TEST(Gradient, is_zero_for_gaussians_that_a_pixel_skips_or_stops_at) {
  Draws draws(2);
  std::vector<double> faint = random_splats(draws, 1, 0.5);
  faint[5] = 0.9 / 255;
  std::vector<double> opaque = random_splats(draws, 1, 0.5);
  opaque[0] = kPixelX, opaque[1] = kPixelY, opaque[5] = 1;
  std::vector<double> x =
      faint;  // three of alpha 0.99 leave 1e-6, so the pixel stops at the second
  for (int i = 0; i < 3; ++i) append(x, opaque);
  const PixelWalk<double> walk(x, glm::dvec3(1));
  ASSERT_EQ(walk.parts[0].step, Step::skips);
  ASSERT_EQ(walk.parts.back().step, Step::stops);
  const auto gradient = pixel_gradients(x, glm::dvec3(1), glm::dvec3(1));
  for (std::size_t i = 0; i < kSplatValues; ++i) EXPECT_EQ(gradient[i], 0) << "skipped";
  EXPECT_NE(gradient[kSplatValues + 6], 0) << "blended";
  for (std::size_t i = (walk.parts.size() - 1) * kSplatValues; i < x.size(); ++i)
    EXPECT_EQ(gradient[i], 0) << "stopped";
}

}  // namespace
}  // namespace qs
