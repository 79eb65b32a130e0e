// SPDX-License-Identifier: MIT
// The gradients of kernel/gradient against differences of the functions in kernel/.
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "learn/gradient/activation.h"
#include "learn/gradient/gaussian.h"
#include "learn/gradient/project.h"
#include "learn/gradient/sh.h"
#include "raster/kernel/activation.h"
#include "raster/kernel/sh.h"
#include "raster/scene/camera.h"
#include "support/differences.h"
#include "support/gradient_arguments.h"

namespace qs {
namespace {

using test::append;
using test::dot;
using test::Draws;
using test::expect_gradient;
using test::kDraws;
using test::list;
using test::rounded;
using test::vec3;

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
          Covariance2<Real> sum{0, 0, 0};
          add_compensation_gradient(c, dilated(c), Real(3), sum, sum);
          return list(sum);
        });
  }
  const Covariance2<double> flat{1e-8, 0, 1e-8};
  ASSERT_LT(flat.determinant() / dilated(flat).determinant(), kCompensationFloor);
  Covariance2<double> none{0, 0, 0};
  add_compensation_gradient(flat, dilated(flat), 3.0, none, none);
  EXPECT_EQ(list(none), std::vector<double>(3, 0));
}

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

// Slopes are clamped to view.slope_limit.
template <class Real>
GeometryGradient<Real> gradient_of_projection(const View<Real>& view,
                                              const glm::vec<3, Real>& point,
                                              const Covariance3<Real>& sigma,
                                              const Covariance2<Real>& d_covariance) {
  return project_covariance_gradient(view, SlopeLimits<Real>::of(view), point, sigma, d_covariance);
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
              gradient_of_projection(make_view<Real>(camera), vec3(x), covariance3(x, 3),
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
    const auto gradient = gradient_of_projection(view, vec3(x), sigma, covariance2(weights));
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

TEST(Gradient, of_the_colour_equals_differences_by_coefficients_and_by_the_mean) {
  Draws draws(9);
  for (int degree = 0; degree <= 3; ++degree) {
    const auto count = static_cast<std::size_t>((degree + 1) * (degree + 1));
    for (int draw = 0; draw < kDraws / 4; ++draw) {
      const std::vector<double> weights = draws.uniform(3, -1, 1);
      // Offset from the camera, then coefficients; a large first coefficient keeps colours above 0.
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

TEST(Gradient, of_a_colour_of_exactly_0_is_zero_in_training) {
  const GradientRules<double> rules{make_view<double>(tilted_camera()), kDilation, false, 0};
  const auto gradient = [&](double coefficient) {
    const auto coefficients = [&](int) { return glm::dvec3(coefficient); };
    return ColorGradient<double>::of(rules, {0, 0, 3}, coefficients, glm::dvec3(1)).by_color;
  };
  const double black = -0.5 / kSh0;
  ASSERT_EQ(kSh0 * black + 0.5, 0);
  EXPECT_EQ(gradient(black), glm::dvec3(0));
  EXPECT_EQ(gradient(black + 1e-9), glm::dvec3(1));
}

}  // namespace
}  // namespace qs
