// SPDX-License-Identifier: MIT
// A colour field in training: gradients against differences in double precision and against golden
// numbers.
#include "learn/field/field_gradient.h"

#include <array>
#include <cmath>
#include <random>
#include <stdexcept>
#include <thread>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "learn/gradient/color_field.h"
#include "learn/gradient/integer_sum.h"
#include "learn/gradient/sh.h"
#include "raster/kernel/constants.h"
#include "support/differences.h"
#include "support/field_outputs.h"
#include "support/golden_field.h"

namespace qs {
namespace {

template <class Real>
std::vector<Real> as(const std::vector<float>& values) {
  return {values.begin(), values.end()};
}

const glm::dvec3 kGoldenMean(0.3, -0.2, 0.5), kGoldenEye(1, 2, -3);

// Means inside and outside of the unit ball, and weights of their outputs.
struct Points {
  std::vector<glm::dvec3> means, weights;
};

Points some_points(std::size_t count) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] { return glm::dvec3(uniform(random), uniform(random), uniform(random)); };
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    points.means.push_back((i % 3 == 2 ? 4.0 : 1.0) * vector());
    points.weights.push_back(vector());
  }
  return points;
}

template <class Real>
struct Sums {
  IntegerSums grid;
  std::vector<Real> weights;
};

template <class Real>
Sums<Real> sums_of(const ColorField& field, const std::vector<Real>& grid,
                   const std::vector<Real>& weights, const Points& points) {
  const FieldGradient<Real> gradient(field.grid, field.width, grid, weights);
  Sums<Real> sums;
  sums.grid.reset(grid.size());
  sums.weights.resize(weights.size());
  for (std::size_t i = 0; i < points.means.size(); ++i) {
    gradient.add(glm::vec<3, Real>(points.means[i]), glm::vec<3, Real>(kGoldenEye),
                 glm::vec<3, Real>(points.weights[i]), sums.grid, std::span<Real>(sums.weights));
  }
  return sums;
}

double loss_of(const ColorField& field, const std::vector<double>& grid,
               const std::vector<double>& weights, const Points& points) {
  const FieldGradient<double> gradient(field.grid, field.width, grid, weights);
  double sum = 0;
  for (std::size_t i = 0; i < points.means.size(); ++i)
    sum += glm::dot(points.weights[i], gradient.output(points.means[i], kGoldenEye));
  return sum;
}

std::vector<double> values_of(const IntegerSums& sums) {
  std::vector<double> values(sums.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = sums.sum(i);
  return values;
}

TEST(FieldGradient, outputs_are_those_of_the_field) {
  for (const ColorField& field : {test::tiny_field(), test::published_field()}) {
    const auto grid = as<double>(field.grid_values), weights = as<double>(field.weights);
    const FieldGradient<double> exact(field.grid, field.width, grid, weights);
    const FieldGradient<float> rounded(field.grid, field.width, field.grid_values, field.weights);
    for (const glm::dvec3& mean : some_points(20).means) {
      const glm::dvec3 expected = test::network_output(field, test::grid_features(field, mean),
                                                       glm::normalize(mean - kGoldenEye));
      const glm::dvec3 output = exact.output(mean, kGoldenEye);
      const glm::vec3 single = rounded.output(glm::vec3(mean), glm::vec3(kGoldenEye));
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(output[c], expected[c], 1e-12);
        EXPECT_NEAR(single[c], expected[c], 1e-2);  // a cell of the finest level is 2e-4 wide
      }
    }
  }
}

TEST(FieldGradient, the_derivative_by_the_mean_has_its_golden_values) {
  const std::array<glm::dvec3, 2> expected = {glm::dvec3(-0.106838154, 0.0961863733, 0.0390923754),
                                              glm::dvec3(-0.120964538, 0.144746006, 0.0667902961)};
  const std::array<ColorField, 2> fields = {test::tiny_field(), test::published_field()};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const auto grid = as<double>(fields[i].grid_values), weights = as<double>(fields[i].weights);
    const FieldGradient<double> gradient(fields[i].grid, fields[i].width, grid, weights);
    IntegerSums sums;
    sums.reset(grid.size());
    std::vector<double> by_weights(weights.size());
    const glm::dvec3 by_direction = gradient.add(kGoldenMean, kGoldenEye, glm::dvec3(1, 2, 3), sums,
                                                 std::span<double>(by_weights));
    const glm::dvec3 by_mean = direction_gradient(kGoldenMean - kGoldenEye, by_direction);
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(by_mean[axis], expected[i][axis], 1e-8);
  }
}

TEST(FieldGradient, derivatives_by_the_grid_equal_differences) {
  const ColorField field = test::tiny_field();
  const Points points = some_points(12);
  const auto grid = as<double>(field.grid_values), weights = as<double>(field.weights);
  const auto expected = test::differences(
      [&](const std::vector<double>& moved) { return loss_of(field, moved, weights, points); },
      grid, 1e-5);
  test::expect_close(values_of(sums_of<double>(field, grid, weights, points).grid), expected, 1e-6);
  test::expect_close(
      values_of(sums_of<float>(field, field.grid_values, field.weights, points).grid), expected,
      1e-3);
}

TEST(FieldGradient, derivatives_by_the_weights_equal_differences) {
  const ColorField field = test::tiny_field();
  const Points points = some_points(12);
  const auto grid = as<double>(field.grid_values), weights = as<double>(field.weights);
  const auto expected = test::differences(
      [&](const std::vector<double>& moved) { return loss_of(field, grid, moved, points); },
      weights, 1e-5);
  test::expect_close(sums_of<double>(field, grid, weights, points).weights, expected, 1e-6);
  test::expect_close(sums_of<float>(field, field.grid_values, field.weights, points).weights,
                     expected, 1e-3);
}

TEST(FieldGradient, derivatives_by_the_direction_equal_differences) {
  const ColorField field = test::tiny_field();
  const auto grid = as<double>(field.grid_values), weights = as<double>(field.weights);
  const FieldGradient<double> gradient(field.grid, field.width, grid, weights);
  const Points points = some_points(12);
  for (std::size_t i = 0; i < points.means.size(); ++i) {
    IntegerSums sums;
    sums.reset(grid.size());
    std::vector<double> by_weights(weights.size());
    const glm::dvec3 mean = points.means[i];
    // The position in the grid has no gradient, so the eye moves in place of the mean.
    const glm::dvec3 by_eye = -direction_gradient(
        mean - kGoldenEye,
        gradient.add(mean, kGoldenEye, points.weights[i], sums, std::span<double>(by_weights)));
    const auto loss = [&](const std::vector<double>& eye) {
      return glm::dot(points.weights[i], gradient.output(mean, {eye[0], eye[1], eye[2]}));
    };
    test::expect_close(std::vector<double>{by_eye.x, by_eye.y, by_eye.z},
                       test::differences(loss, {1, 2, -3}, 1e-5), 1e-6);
  }
}

TEST(FieldGradient, a_black_channel_passes_only_what_makes_it_brighter) {
  const glm::dvec3 color(0.5, 0, 0), by(2, -3, 4);
  EXPECT_EQ(output_gradient(color, by), glm::dvec3(2 * kSh0, -3 * kSh0, 0));
}

TEST(FieldGradient, sums_of_the_grid_do_not_depend_on_the_order_of_threads) {
  IntegerSums one, many;
  one.reset(3);
  many.reset(3);
  const auto value = [](int k) { return std::sin(k) * std::exp2(k % 20 - 30); };
  for (int k = 0; k < 4000; ++k) one.add(static_cast<std::size_t>(k % 2), value(k));
  {
    std::vector<std::jthread> threads;
    for (int thread = 0; thread < 4; ++thread) {
      threads.emplace_back([&, thread] {
        for (int k = 3999 - thread; k >= 0; k -= 4)
          many.add(static_cast<std::size_t>(k % 2), value(k));
      });
    }
  }
  EXPECT_EQ(values_of(many), values_of(one));
  EXPECT_NE(one.sum(0), 0);
  EXPECT_EQ(one.sum(2), 0);
}

TEST(FieldGradient, derivatives_are_rounded_to_units_of_the_sums_halves_away_from_zero) {
  constexpr double kUnits = 1 / kSumUnit;
  for (const double units : {0.0, 0.25, 0.5, 1.0, 1.5, 2.5, 0x1p22 + 0.5, 0x1p23 + 1, 0x1p40}) {
    for (const float value :
         {static_cast<float>(units), std::nextafter(static_cast<float>(units), 0.0f),
          std::nextafter(static_cast<float>(units), INFINITY)}) {
      for (const float sign : {1.0f, -1.0f}) {
        EXPECT_EQ(sum_units(sign * value * 0x1p-40f), std::llround(sign * value)) << sign * value;
        const double precise = sign * (double{value} + 0x1p-30);
        EXPECT_EQ(sum_units(precise / kUnits), std::llround(precise)) << precise;
      }
    }
  }
}

TEST(FieldGradient, derivatives_that_are_not_finite_add_nothing_and_huge_ones_are_limited) {
  IntegerSums sums;
  sums.reset(2);
  for (const double bad : {NAN, INFINITY, -INFINITY}) sums.add(0, bad);
  EXPECT_EQ(sums.sum(0), 0);
  sums.add(1, 1e30);
  EXPECT_EQ(sums.sum(1), 0x1p20);
  sums.add(1, -1e30);
  EXPECT_EQ(sums.sum(1), 0);
}

TEST(FieldGradient, a_network_that_is_too_large_is_refused) {
  const ColorField field = test::golden_field(test::kTinyGrid, 80);
  EXPECT_THROW(FieldGradient<float>(field.grid, field.width, field.grid_values, field.weights),
               std::length_error);
}

}  // namespace
}  // namespace qs
