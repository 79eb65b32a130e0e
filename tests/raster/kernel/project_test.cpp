// SPDX-License-Identifier: MIT
// The functions of kernel/ against double precision and against independent definitions.
#include "raster/kernel/project.h"

#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "raster/kernel/blend.h"
#include "raster/kernel/sh.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/camera.h"
#include "support/oracle.h"
#include "support/scenes.h"

namespace qs {
namespace {

TEST(Project, spherical_harmonics_equal_their_definition_by_legendre_functions) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int draw = 0; draw < 200; ++draw) {
    const glm::dvec3 d = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    for (int k = 0; k < 16; ++k) {
      const int l = static_cast<int>(std::sqrt(k)), m = k - l * l - l;
      // +3 avoids the clamp at zero.
      const auto only_k = [&](int i) { return glm::dvec3(i == k ? 1.0 : (i == 0 ? 10.0 : 0.0)); };
      const double base = k == 0 ? 0.0 : 10.0 * test::spherical_harmonic(0, 0, d);
      EXPECT_NEAR(sh_color<double>(3, d, only_k).x, 0.5 + base + test::spherical_harmonic(l, m, d),
                  1e-12)
          << "coefficient " << k;
      const auto only_k_float = [&](int i) { return glm::vec3(only_k(i)); };
      EXPECT_NEAR(sh_color<float>(3, glm::vec3(d), only_k_float).x,
                  sh_color<double>(3, d, only_k).x, 4e-6);
    }
  }
}

TEST(Project, colours_are_clamped_below_but_not_above) {
  const auto dark = [](int) { return glm::vec3(-10, 0, 10); };
  const glm::vec3 color = sh_color<float>(0, glm::vec3(0, 0, 1), dark);
  EXPECT_EQ(color.x, 0.0f);
  EXPECT_EQ(color.y, 0.5f);
  EXPECT_GT(color.z, 3.0f);
}

TEST(Project, the_covariance_is_that_of_the_projected_points) {
  // For a small Gaussian: numerical derivatives of the pixel position along its axes.
  std::mt19937 random(5);
  const GaussianCloud cloud = test::random_cloud(400, 0, 11);
  const Camera camera = look_at({0.3, -0.2, -1}, {0.1, 0, 3}, {0, -1, 0.1}, 1.0, 640, 480);
  const View<double> view = make_view<double>(camera);
  int checked = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 p(cloud.positions[i]);
    const glm::dvec3 point = to_view(view, p);
    if (point.z < 0.5 || std::abs(point.x / point.z) > view.slope_limit.x ||
        std::abs(point.y / point.z) > view.slope_limit.y)
      continue;
    ++checked;
    const Covariance3<double> s = world_covariance(cloud, i);
    const glm::dmat3 sigma(s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz);
    glm::dvec3 grad_u, grad_v;
    for (int k = 0; k < 3; ++k) {
      glm::dvec3 step(0);
      step[k] = 1e-5;
      const glm::dvec2 difference =
          (to_pixel(view, to_view(view, p + step)) - to_pixel(view, to_view(view, p - step))) /
          2e-5;
      grad_u[k] = difference.x;
      grad_v[k] = difference.y;
    }
    const Covariance2<double> c = project_covariance(view, point, s);
    const double scale = c.xx + c.yy;
    EXPECT_NEAR(c.xx, glm::dot(grad_u, sigma * grad_u), 1e-6 * scale);
    EXPECT_NEAR(c.xy, glm::dot(grad_u, sigma * grad_v), 1e-6 * scale);
    EXPECT_NEAR(c.yy, glm::dot(grad_v, sigma * grad_v), 1e-6 * scale);
  }
  EXPECT_GT(checked, 100);
}

TEST(Project, float_agrees_with_double) {
  const GaussianCloud cloud = test::random_cloud(2000, 0, 3);
  const Camera camera = test::front_camera(640, 480);
  const View<float> view = make_view<float>(camera);
  const View<double> exact = make_view<double>(camera);
  ThreadPool pool(1);
  const ActivatedCloud active = activate(cloud, pool);
  int checked = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Projected projected;
    if (!project(view, {true, false, 1.0f}, active.gaussians[i], projected)) continue;
    ++checked;
    const glm::dvec3 point = to_view(exact, glm::dvec3(cloud.positions[i]));
    Covariance2<double> c = project_covariance(exact, point, world_covariance(cloud, i));
    c.xx += kDilation;
    c.yy += kDilation;
    const glm::dvec2 mean = to_pixel(exact, point);
    const Footprint& f = projected.footprint;
    EXPECT_NEAR(f.mean_px.x, mean.x, 1e-3 + 1e-6 * std::abs(mean.x));
    EXPECT_NEAR(f.mean_px.y, mean.y, 1e-3 + 1e-6 * std::abs(mean.y));
    EXPECT_NEAR(f.covariance.xx, c.xx, 2e-6 * (c.xx + c.yy));
    EXPECT_NEAR(f.covariance.xy, c.xy, 2e-6 * (c.xx + c.yy));
    EXPECT_NEAR(f.covariance.yy, c.yy, 2e-6 * (c.xx + c.yy));
    EXPECT_NEAR(f.gamma, 2 * std::log(255 * opacity_of_logit(cloud.opacity_logits[i])), 1e-5);
  }
  EXPECT_GT(checked, 1500);
}

TEST(Project, rejects_what_has_no_footprint) {
  const View<float> view = make_view<float>(test::front_camera(64, 64));
  const FootprintRules rules{false, false, 1.0f};
  const Covariance3<float> unit{1, 0, 0, 1, 0, 1};
  Projected out;
  EXPECT_TRUE(project(view, rules, {{0, 0, 1}, unit, 7.0f}, out));
  EXPECT_FALSE(project(view, rules, {{0, 0, 0.2f}, unit, 7.0f}, out)) << "at the near plane";
  EXPECT_FALSE(project(view, rules, {{0, 0, -1}, unit, 7.0f}, out)) << "behind";
  EXPECT_FALSE(project(view, rules, {{0, 0, 1}, unit, 0.0f}, out)) << "opacity 1/255";
  EXPECT_FALSE(project(view, rules, {{0, 0, 1}, unit, -INFINITY}, out)) << "opacity 0";
  EXPECT_TRUE(project(view, {true, false, 1.0f}, {{0, 0, 1}, unit, -INFINITY}, out))
      << "3dgs keeps it";
  const Covariance3<float> huge{INFINITY, 0, 0, INFINITY, 0, INFINITY},
      bad{NAN, NAN, NAN, NAN, NAN, NAN};
  EXPECT_FALSE(project(view, rules, {{0, 0, 1}, huge, 7.0f}, out));
  EXPECT_FALSE(project(view, rules, {{0, 0, 1}, bad, 7.0f}, out));
  EXPECT_FALSE(project(view, rules, {{NAN, 0, 1}, unit, 7.0f}, out));
  EXPECT_FALSE(project(view, rules, {{1e38f, 0, 1}, unit, 7.0f}, out));
}

TEST(Project, portable_logarithm_is_accurate) {
  for (int i = 1; i <= 100000; ++i) {
    const float x = static_cast<float>(i) * 1e-5f;
    EXPECT_NEAR(log2_portable(x), std::log2(static_cast<double>(x)), 2e-6) << x;
  }
  EXPECT_EQ(log2_portable(1.0f), 0.0f);
  EXPECT_EQ(log2_portable(0.25f), -2.0f);
}

TEST(Blend, polynomial_exponential_is_accurate_to_2e_minus_7) {
  for (float x = -125.9f; x < 8.0f; x += 0.00037f) {
    const double expected = std::exp2(static_cast<double>(x));
    EXPECT_NEAR(exp2_polynomial(x), expected, 2e-7 * expected) << x;
  }
  EXPECT_EQ(exp2_polynomial(0.0f), 1.0f);
  EXPECT_EQ(exp2_polynomial(-3.0f), 0.125f);
  EXPECT_LE(exp2_polynomial(-INFINITY), 1.2e-38f);
}

}  // namespace
}  // namespace qs
