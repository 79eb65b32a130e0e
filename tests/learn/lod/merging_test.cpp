// SPDX-License-Identifier: MIT
//
// Merging against analytic cases, and the closed form of its error against sums over pixels.
#include "learn/lod/merging.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "support/lod_errors.h"

namespace qs::test {
namespace {

constexpr double kPi = std::numbers::pi;

LodGaussian lod_ball(glm::vec3 mean, float sigma, float opacity, float grey = 0) {
  LodGaussian g;
  g.mean = mean;
  g.covariance = {sigma * sigma, 0, 0, sigma * sigma, 0, sigma * sigma};
  g.color = {grey, grey, grey};
  set_opacity(g, opacity);
  return g;
}

TEST(Merging, the_area_is_that_of_the_ellipsoid) {
  // Surface areas of ellipsoids with the axes a, b, c: closed forms of balls, spheroids and discs.
  const double e = std::sqrt(1 - 0.25);  // eccentricity of the axes 1 and 0.5
  struct Row {
    double a, b, c, area;
  };
  const double oblate = 2 * kPi * (1 + (1 - e * e) / e * std::atanh(e));
  const double prolate = 2 * kPi * 0.25 * (1 + 2 / e * std::asin(e));
  const std::vector<Row> rows = {
      {1, 1, 1, 4 * kPi},          {3, 3, 3, 36 * kPi},          {1, 1, 0.5, oblate},
      {1, 0.5, 0.5, prolate},      {1, 1, 0, 2 * kPi},           {2, 1, 0, 4 * kPi},
      {1e-4, 1e-4, 0, 2e-8 * kPi}, {100, 1, 1, kPi * kPi * 100}, {1e6, 1, 1, kPi * kPi * 1e6}};
  for (const Row& row : rows) {
    const auto square = [](double v) { return static_cast<float>(v * v); };
    const LodCovariance along{square(row.a), 0, 0, square(row.b), 0, square(row.c)};
    EXPECT_NEAR(static_cast<double>(ellipsoid_area(along)) / row.area, 1, 0.025)
        << row.a << " " << row.b << " " << row.c;
  }
  EXPECT_EQ(ellipsoid_area({}), 0);
}

TEST(Merging, the_area_does_not_depend_on_the_rotation) {
  // diag(4, 1, 0.25) turned by 45 degrees about z, then about x.
  const float area = ellipsoid_area({4, 0, 0, 1, 0, 0.25f});
  EXPECT_NEAR(ellipsoid_area({2.5f, 1.5f, 0, 2.5f, 0, 0.25f}) / area, 1, 1e-5);
  const float r = std::sqrt(0.5f);
  EXPECT_NEAR(ellipsoid_area({2.5f, 1.5f * r, 1.5f * r, 1.375f, 1.125f, 1.375f}) / area, 1, 1e-5);
}

TEST(Merging, harmonic_numbers_are_sums_of_reciprocals) {
  double sum = 0;
  for (int m = 1; m <= 1000; ++m) {
    sum += 1.0 / m;
    EXPECT_NEAR(static_cast<double>(harmonic_number(static_cast<float>(m))) / sum, 1, 2e-3);
  }
}

TEST(Merging, equal_gaussians_at_one_place_add_their_opacities) {
  const LodGaussian a = lod_ball({1, 2, 3}, 0.5f, 0.3f, 0.2f);
  const LodGaussian node = merged(a, a);
  EXPECT_EQ(node.mean, a.mean);
  EXPECT_EQ(node.color, a.color);
  EXPECT_FLOAT_EQ(node.mass, 2 * a.mass);
  const DrawnLod shown = drawn(node, 0);
  EXPECT_NEAR(shown.opacity, 0.6f, 1e-5);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(shown.covariance[i], a.covariance[i], 1e-6);
  // One hides a part of the other Gaussian: the picture lacks 0.09 G^2, whose square has the
  // integral 0.0081 * 2 pi * variance / 4 in a grey of 3 * 0.2^2 and an opacity of weight 0.25.
  EXPECT_NEAR(static_cast<double>(merging_error(a, a, 0.1f, false)),
              0.0081 * 2 * kPi * 0.35 / 4 * 0.37, 1e-5);
}

TEST(Merging, opaque_gaussians_at_one_place_grow_by_a_harmonic_number) {
  LodGaussian node = lod_ball({0, 0, 0}, 1, 1);
  for (int k = 0; k < 3; ++k) node = merged(node, lod_ball({0, 0, 0}, 1, 1));
  const DrawnLod shown = drawn(node, 0);
  EXPECT_EQ(shown.opacity, 1);
  EXPECT_NEAR(shown.covariance[0], 1 + 1 / 2. + 1 / 3. + 1 / 4., 0.005);
}

TEST(Merging, exponential_integrals_are_integrals) {
  double sum = 0, t = 0;
  for (const double m : {1e-4, 0.5, 0.99, 1.01, 1.5, 4.0, 20.0, 49.0, 51.0, 90.0}) {
    constexpr int kSteps = 20000;
    const double step = (m - t) / kSteps;
    for (int i = 0; i < kSteps; ++i) {
      const double middle = t + (i + 0.5) * step;
      sum += step * -std::expm1(-middle) / middle;
    }
    t = m;
    EXPECT_NEAR(static_cast<double>(exponential_integral(static_cast<float>(m))) / sum, 1, 1e-4);
  }
  EXPECT_EQ(exponential_integral(0), 0);
  EXPECT_NEAR(exponential_integral(1e30f), 69.65f, 0.01f);
}

TEST(Merging, faint_gaussians_behind_a_filter_hide_each_other) {
  // 1 - (1 - 0.05 g)^n has the integral of the sum of (1 - 0.95^k) / k, if g has 1.
  for (const int count : {2, 10, 40, 200}) {
    LodGaussian node = lod_ball({0, 0, 0}, 1, 0.05f);
    for (int k = 1; k < count; ++k) node = merged(node, lod_ball({0, 0, 0}, 1, 0.05f));
    double truth = 0;
    for (int k = 1; k <= count; ++k) truth += (1 - std::pow(0.95, k)) / k;
    const DrawnLod shown = drawn_faint(node, 1);
    const double covered = static_cast<double>(shown.opacity * (shown.covariance[0] + 1) / 2);
    EXPECT_NEAR(covered / truth, 1, 0.02) << count;
  }
}

TEST(Merging, layers_that_hide_each_other_cost_little) {
  // Both are opaque at one place: their sum would be twice as bright as the picture.
  const LodGaussian a = lod_ball({0, 0, 0}, 1, 1, 0.4f), b = lod_ball({0.1f, 0, 0}, 1, 1, 0.4f);
  EXPECT_LT(static_cast<double>(merging_error(a, b, 0, false)), 0.05 * kPi * (0.25 + 3 * 0.16));
}

TEST(Merging, moments_of_a_distant_pair_are_those_of_the_mixture) {
  // Masses 3 : 1, so the mean is at a quarter of the way, and the spread along x is p q d^2.
  const LodGaussian a = lod_ball({0, 0, 0}, 1, 0.6f, 0.4f), b = lod_ball({8, 0, 0}, 1, 0.2f, -0.4f);
  const LodGaussian node = merged(a, b);
  EXPECT_FLOAT_EQ(share_of(a, b), 0.75f);
  EXPECT_FLOAT_EQ(node.mean.x, 2);
  EXPECT_FLOAT_EQ(node.covariance[0], 1 + 0.1875f * 64);
  EXPECT_FLOAT_EQ(node.covariance[3], 1);
  EXPECT_FLOAT_EQ(node.color[0], 0.75f * 0.4f - 0.25f * 0.4f);
  // Two far apart share nothing: the error is about the sum of the three separate energies.
  EXPECT_GT(merging_error(a, b, 0, false), 0.1f);
}

TEST(Merging, gaussians_that_show_nothing_merge_without_nan) {
  const LodGaussian a = lod_ball({0, 0, 0}, 1, 0), b = lod_ball({2, 0, 0}, 0, 0.5f);
  for (const LodGaussian& node : {merged(a, a), merged(a, b), merged(b, b)})
    for (const float v : {0.0f, 0.5f})
      for (const bool antialiased : {false, true}) {
        const float error = merging_error(a, b, v, antialiased);
        EXPECT_TRUE(std::isfinite(error));
        EXPECT_TRUE(std::isfinite(drawn(node, v).opacity));
        EXPECT_TRUE(std::isfinite(drawn_faint(node, v).opacity));
      }
}

TEST(Merging, gaussians_far_apart_or_huge_have_a_finite_error) {
  const LodGaussian a = lod_ball({0, 0, 0}, 1, 0.5f);
  for (const LodGaussian& b :
       {lod_ball({1e18f, 0, 0}, 1, 0.5f), lod_ball({0, 0, 0}, 1e16f, 0.5f),
        lod_ball({1e18f, -1e18f, 0}, 1e18f, 1), lod_ball({0, 0, 0}, 1e-18f, 1)})
    for (const float v : {0.0f, 1e-20f, 1e10f})
      EXPECT_TRUE(std::isfinite(merging_error(a, b, v, false)));
}

TEST(Merging, leaves_are_drawn_as_they_are) {
  const LodGaussian a = lod_ball({0, 0, 0}, 1, 0.7f);
  for (const float v : {0.0f, 0.3f, 1e6f}) {
    EXPECT_EQ(drawn(a, v).opacity, 0.7f);
    EXPECT_EQ(drawn(a, v).covariance, a.covariance);
  }
}

TEST(Merging, far_away_the_opacity_counts_the_dilation_of_every_leaf) {
  // Far smaller than the filter: each covers 2 pi v of its opacity, and so does the node.
  const LodGaussian a = lod_ball({0, 0, 0}, 1e-3f, 0.2f), b = lod_ball({0.01f, 0, 0}, 1e-3f, 0.3f);
  const LodGaussian node = merged(a, b);
  EXPECT_LT(drawn(node, 0).opacity, 0.3f);
  EXPECT_NEAR(drawn(node, 1).opacity, 0.5f, 1e-3);
}

// The error as sums over pixels, seen along each axis. The mean over both orders of the pair is
// the picture of both minus their product in the mean colour.
double summed_error(const LodGaussian& a, const LodGaussian& b, double v, bool antialiased) {
  const LodGaussian node = merged(a, b);
  double total = 0;
  for (const auto& [x, y] : {std::pair{1, 2}, std::pair{0, 2}, std::pair{0, 1}}) {
    const auto value = [&, x = x, y = y](const LodGaussian& g, double px, double py) {
      static constexpr int kIndex[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
      const DrawnLod shown = drawn(g, antialiased ? 0 : static_cast<float>(v));
      const auto c = [&](int i, int k) {
        return static_cast<double>(shown.covariance[static_cast<std::size_t>(kIndex[i][k])]);
      };
      const double sharp = c(x, x) * c(y, y) - c(x, y) * c(x, y);
      const double xx = c(x, x) + v, yy = c(y, y) + v, xy = c(x, y), det = xx * yy - xy * xy;
      const double dx = px - static_cast<double>(g.mean[x]),
                   dy = py - static_cast<double>(g.mean[y]);
      const double q = (yy * dx * dx - 2 * xy * dx * dy + xx * dy * dy) / det;
      return static_cast<double>(shown.opacity) * (antialiased ? std::sqrt(sharp / det) : 1) *
             std::exp(-q / 2);
    };
    constexpr double kStep = 0.1;
    for (double py = -8; py < 8; py += kStep)
      for (double px = -8; px < 8; px += kStep) {
        const double va = value(a, px, py), vb = value(b, px, py), vn = value(node, px, py);
        const double opacity = va + vb - va * vb - vn;
        double sum = 0.25 * opacity * opacity;  // its weight
        for (std::size_t i = 0; i < kLodColors; ++i) {
          const double d = va * (1 - vb / 2) * static_cast<double>(a.color[i]) +
                           vb * (1 - va / 2) * static_cast<double>(b.color[i]) -
                           vn * static_cast<double>(node.color[i]);
          sum += d * d;
        }
        total += sum * kStep * kStep / 3;
      }
  }
  return total;
}

TEST(Merging, the_error_is_the_integral_of_the_squared_difference) {
  LodGaussian flat = lod_ball({0.5f, 0, -0.5f}, 1, 0.9f, -0.3f), turned = flat;
  flat.covariance = {1, 0, 0, 0.04f, 0, 0.25f};
  set_opacity(flat, 0.9f);
  turned.covariance = {0.6f, 0.3f, 0.1f, 0.5f, -0.1f, 0.4f};
  turned.color = {0.5f, -0.5f, 0.1f, 0.2f, 0, 0, 0, -0.1f};
  set_opacity(turned, 0.5f);
  const std::vector<LodGaussian> all = {lod_ball({0, 0, 0}, 0.5f, 0.8f, 0.5f),
                                        lod_ball({1, 1, 0}, 0.7f, 0.4f, -0.5f), flat, turned,
                                        merged(flat, flat)};
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      for (const float v : {0.05f, 0.5f})
        for (const bool antialiased : {false, true}) {
          const float error = merging_error(all[i], all[k], v, antialiased);
          const double summed = summed_error(all[i], all[k], static_cast<double>(v), antialiased);
          EXPECT_NEAR(static_cast<double>(error), summed, 0.002 + 0.01 * summed)
              << i << " " << k << " " << v << " " << antialiased;
        }
}

}  // namespace
}  // namespace qs::test
