// SPDX-License-Identifier: MIT
// The gradients of kernel/gradient against differences of the functions in kernel/.
#include <random>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "raster/kernel/activation.h"
#include "raster/kernel/composite.h"
#include "raster/kernel/gradient/activation.h"
#include "raster/kernel/gradient/footprint.h"
#include "raster/kernel/gradient/pixel.h"
#include "raster/kernel/gradient/project.h"
#include "raster/kernel/gradient/sh.h"
#include "raster/kernel/sh.h"
#include "raster/scene/camera.h"
#include "support/differences.h"

namespace qs {
namespace {

using test::expect_gradient;

constexpr int kDraws = 50;

class Draws {
 public:
  explicit Draws(unsigned seed) : random_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  std::vector<double> uniform(std::size_t count, double low, double high) {
    std::vector<double> values(count);
    for (double& value : values) value = uniform(low, high);
    return values;
  }

 private:
  std::mt19937 random_;
};

template <class Real>
glm::vec<3, Real> vec3(const std::vector<Real>& x, std::size_t at = 0) {
  return {x[at], x[at + 1], x[at + 2]};
}

template <class Real>
std::vector<Real> list(const glm::vec<3, Real>& v) {
  return {v.x, v.y, v.z};
}

template <class Real>
std::vector<Real> list(const Covariance2<Real>& c) {
  return {c.xx, c.xy, c.yy};
}

template <class Real>
std::vector<Real> list(const Covariance3<Real>& c) {
  return {c.xx, c.xy, c.xz, c.yy, c.yz, c.zz};
}

template <class Real>
void append(std::vector<Real>& list, const std::vector<Real>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

template <class Real>
std::vector<Real> rounded(const std::vector<double>& values) {
  return std::vector<Real>(values.begin(), values.end());
}

// ---- pixels
// --------------------------------------------------------------------------------------

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
    SplatGradient<Real> sum;
    add_pixel_gradient<Real>(splat_of(x, i), kPixelX, kPixelY, part.alpha, part.in_front,
                             walk.color - part.upto, glm::vec<3, Real>(d_pixel), sum);
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

// ---- footprints
// ----------------------------------------------------------------------------------

std::vector<double> random_covariance2(Draws& draws) {
  const double xx = draws.uniform(0.5, 4), yy = draws.uniform(0.5, 4);
  return {xx, draws.uniform(-0.8, 0.8) * std::sqrt(xx * yy), yy};
}

template <class Real>
Covariance2<Real> covariance2(const std::vector<Real>& x) {
  return {x[0], x[1], x[2]};
}

TEST(Gradient, of_the_conic_equals_differences) {
  Draws draws(3);
  for (int draw = 0; draw < kDraws; ++draw) {
    const std::vector<double> weights = draws.uniform(3, -1, 1);
    expect_gradient(
        [&](const auto& x) {
          const Covariance2<double> c = covariance2(x);
          return dot(weights,
                     {c.yy / c.determinant(), -c.xy / c.determinant(), c.xx / c.determinant()});
        },
        random_covariance2(draws),
        [&]<class Real>(const std::vector<Real>& x) {
          return list(conic_gradient(covariance2(x), vec3(rounded<Real>(weights))));
        });
  }
}

TEST(Gradient, of_the_opacity_compensation_equals_differences) {
  Draws draws(4);
  const auto dilated = []<class Real>(Covariance2<Real> c) {
    c.xx += static_cast<Real>(kDilation);
    c.yy += static_cast<Real>(kDilation);
    return c;
  };
  for (int draw = 0; draw < kDraws; ++draw) {
    expect_gradient(
        [&](const auto& x) {
          const Covariance2<double> c = covariance2(x);
          return 3 * compensation(c.determinant(), dilated(c).determinant());
        },
        random_covariance2(draws),
        [&]<class Real>(const std::vector<Real>& x) {
          const Covariance2<Real> c = covariance2(x);
          return list(compensation_gradient(c, dilated(c), Real(3)));
        });
  }
  const Covariance2<double> flat{1e-8, 0, 1e-8};
  ASSERT_LT(flat.determinant() / dilated(flat).determinant(), kCompensationFloor);
  EXPECT_EQ(list(compensation_gradient(flat, dilated(flat), 3.0)), std::vector<double>(3, 0));
}

// ---- projection
// ----------------------------------------------------------------------------------

Camera tilted_camera() {
  return look_at({0.3, -0.2, -1}, {0.1, 0, 3}, {0, -1, 0.1}, 1.0, 640, 480);
}

template <class Real>
Covariance3<Real> covariance3(const std::vector<Real>& x, std::size_t at) {
  return {x[at], x[at + 1], x[at + 2], x[at + 3], x[at + 4], x[at + 5]};
}

// A point in view axes within the slope limits or beyond one of them, then a covariance.
std::vector<double> random_projection(Draws& draws, const View<double>& view, double slope_x,
                                      double slope_y) {
  const double z = draws.uniform(1, 6);
  std::vector<double> x = {slope_x * view.slope_limit.x * z, slope_y * view.slope_limit.y * z, z};
  const std::vector<double> log_scale = draws.uniform(3, -2, 0), q = draws.uniform(4, -1, 1);
  append(x,
         list(covariance_of(vec3(log_scale), glm::normalize(glm::dquat(q[0], q[1], q[2], q[3])))));
  return x;
}

TEST(Gradient, of_the_projected_covariance_equals_differences_also_through_the_jacobian) {
  Draws draws(5);
  const Camera camera = tilted_camera();
  const View<double> view = make_view<double>(camera);
  for (int draw = 0; draw < kDraws; ++draw) {
    const std::vector<double> weights = draws.uniform(3, -1, 1);
    expect_gradient(
        [&](const auto& x) {
          return dot(weights, list(project_covariance(view, vec3(x), covariance3(x, 3))));
        },
        random_projection(draws, view, draws.uniform(-0.9, 0.9), draws.uniform(-0.9, 0.9)),
        [&]<class Real>(const std::vector<Real>& x) {
          const auto gradient =
              project_covariance_gradient(make_view<Real>(camera), vec3(x), covariance3(x, 3),
                                          covariance2(rounded<Real>(weights)));
          std::vector<Real> result = list(gradient.mean);
          append(result, list(gradient.covariance));
          return result;
        });
  }
}

TEST(Gradient, of_the_projected_covariance_treats_a_clamped_slope_as_a_constant) {
  // With both slopes at their limits the Jacobian depends on z alone, as 1 / z: so does its square.
  Draws draws(6);
  const View<double> view = make_view<double>(tilted_camera());
  for (const double side : {-1.5, 1.5}) {
    const std::vector<double> x = random_projection(draws, view, side, -side);
    const Covariance3<double> sigma = covariance3(x, 3);
    const std::vector<double> weights = draws.uniform(3, -1, 1);
    const auto gradient = project_covariance_gradient(view, vec3(x), sigma, covariance2(weights));
    const double value = dot(weights, list(project_covariance(view, vec3(x), sigma)));
    EXPECT_EQ(gradient.mean.x, 0);
    EXPECT_EQ(gradient.mean.y, 0);
    EXPECT_NEAR(gradient.mean.z, -2 * value / x[2], 1e-10 * std::abs(value));
  }
}

TEST(Gradient, of_the_pixel_position_equals_differences_in_the_world) {
  Draws draws(7);
  const Camera camera = tilted_camera();
  const View<double> view = make_view<double>(camera);
  for (int draw = 0; draw < kDraws; ++draw) {
    const glm::dvec2 weights(draws.uniform(-1, 1), draws.uniform(-1, 1));
    expect_gradient(
        [&](const auto& x) { return glm::dot(weights, to_pixel(view, to_view(view, vec3(x)))); },
        {draws.uniform(-1, 1), draws.uniform(-1, 1), draws.uniform(2, 6)},
        [&]<class Real>(const std::vector<Real>& x) {
          const View<Real> rounded_view = make_view<Real>(camera);
          return list(view_gradient(rounded_view,
                                    pixel_gradient(rounded_view, to_view(rounded_view, vec3(x)),
                                                   glm::vec<2, Real>(weights))));
        });
  }
}

// ---- activation
// ----------------------------------------------------------------------------------

template <class Real>
glm::qua<Real> quaternion(const std::vector<Real>& x, std::size_t at) {
  return {x[at], x[at + 1], x[at + 2], x[at + 3]};
}

TEST(Gradient, of_the_covariance_equals_differences_also_for_quaternions_of_any_length) {
  Draws draws(8);
  for (int draw = 0; draw < kDraws; ++draw) {
    const std::vector<double> weights = draws.uniform(6, -1, 1);
    std::vector<double> at = draws.uniform(3, -2, 1);
    append(at, draws.uniform(4, -2, 2));
    expect_gradient(
        [&](const auto& x) {
          return dot(weights, list(covariance_of(vec3(x), unit_rotation(quaternion(x, 3)))));
        },
        at,
        [&]<class Real>(const std::vector<Real>& x) {
          const auto gradient = covariance_gradient(vec3(x), quaternion(x, 3),
                                                    covariance3(rounded<Real>(weights), 0));
          std::vector<Real> result = list(gradient.log_scale);
          const glm::qua<Real>& q = gradient.rotation;
          append(result, {q.w, q.x, q.y, q.z});
          return result;
        });
  }
}

TEST(Gradient, of_the_opacity_equals_differences) {
  for (const double logit : {-6.0, -1.0, 0.0, 0.5, 4.0}) {
    expect_gradient([](const auto& x) { return 2 * opacity_of(x[0]); }, {logit},
                    []<class Real>(const std::vector<Real>& x) {
                      return std::vector<Real>{opacity_gradient(opacity_of(x[0]), Real(2))};
                    });
  }
}

// ---- colour
// --------------------------------------------------------------------------------------

TEST(Gradient, of_the_colour_equals_differences_by_coefficients_and_by_the_mean) {
  Draws draws(9);
  for (int degree = 0; degree <= 3; ++degree) {
    const auto count = static_cast<std::size_t>((degree + 1) * (degree + 1));
    for (int draw = 0; draw < kDraws / 4; ++draw) {
      const std::vector<double> weights = draws.uniform(3, -1, 1);
      // Offset from the camera, then coefficients; a large first one keeps colours above 0.
      std::vector<double> at = {draws.uniform(-1, 1), draws.uniform(-1, 1), draws.uniform(1, 3)};
      append(at, draws.uniform(3 * count, -0.5, 0.5));
      for (std::size_t i = 3; i < 6; ++i) at[i] += 12;
      expect_gradient(
          [&](const auto& x) {
            const auto color = sh_color<double>(degree, glm::normalize(vec3(x)), [&](int k) {
              return vec3(x, 3 + 3 * static_cast<std::size_t>(k));
            });
            return dot(weights, list(color));
          },
          at,
          [&]<class Real>(const std::vector<Real>& x) {
            std::vector<Real> result(x.size());
            const auto d_direction = sh_gradient<Real>(
                degree, glm::normalize(vec3(x)),
                [&](int k) { return vec3(x, 3 + 3 * static_cast<std::size_t>(k)); },
                vec3(rounded<Real>(weights)),
                [&](int k, const glm::vec<3, Real>& gradient) {
                  const std::vector<Real> values = list(gradient);
                  std::copy(values.begin(), values.end(),
                            result.begin() + 3 + 3 * static_cast<std::ptrdiff_t>(k));
                });
            const std::vector<Real> mean = list(direction_gradient(vec3(x), d_direction));
            std::copy(mean.begin(), mean.end(), result.begin());
            return result;
          });
    }
  }
}

TEST(Gradient, of_a_colour_clamped_at_0_is_zero) {
  const glm::dvec3 gradient = clamp_gradient(glm::dvec3(0, 0.5, 3), glm::dvec3(1, 2, 3));
  EXPECT_EQ(gradient, glm::dvec3(0, 2, 3));
}

}  // namespace
}  // namespace qs
