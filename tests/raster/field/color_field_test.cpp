// SPDX-License-Identifier: MIT
//
// Golden values come from a program in NumPy that was written from the published rules, in double
// precision.
#include "raster/field/color_field.h"

#include <array>
#include <numeric>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "raster/field/field_evaluator.h"
#include "raster/kernel/sh.h"
#include "support/field_outputs.h"
#include "support/golden_field.h"
#include "support/instruction_set.h"

namespace qs {
namespace {

using testing::ElementsAre;

const glm::dvec3 kMean(0.3, -0.2, 0.5), kEye(1, 2, -3);
const glm::dvec3 kDirection = glm::normalize(kMean - kEye);

// The entry of the lowest corner of the cell of `mean`, by level.
std::vector<std::uint32_t> first_corners(const GridShape& grid, const glm::dvec3& mean) {
  std::vector<std::uint32_t> entries;
  for (const GridLevel& level : grid_levels(grid)) {
    const glm::dvec3 cell = glm::floor(static_cast<double>(level.scale) * contract(mean) + 0.5);
    entries.push_back(grid_entry(level, static_cast<std::uint32_t>(cell.x),
                                 static_cast<std::uint32_t>(cell.y),
                                 static_cast<std::uint32_t>(cell.z)));
  }
  return entries;
}

void expect_near(const glm::dvec3& value, const std::array<double, 3>& expected, double bound) {
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(value[i], expected[static_cast<std::size_t>(i)], bound) << i;
}

glm::dvec3 output(const ColorField& field, const glm::dvec3& mean, const glm::dvec3& direction) {
  return test::network_output(field, test::grid_features(field, mean), direction);
}

TEST(ColorField, has_the_sizes_of_the_published_models) {
  EXPECT_EQ(grid_value_count({}), 12'599'920u);
  EXPECT_EQ(ColorField().network().weight_count(), 8192u);
  EXPECT_EQ(grid_value_count(test::kTinyGrid), 448u);
  EXPECT_EQ((NetworkShape{8, 16}.weight_count()), 1024u);
  std::vector<std::uint32_t> resolutions, entries;
  for (const GridLevel& level : grid_levels({})) {
    resolutions.push_back(level.resolution);
    entries.push_back(level.entries);
  }
  EXPECT_THAT(resolutions, ElementsAre(16, 24, 34, 49, 71, 102, 147, 213, 308, 445, 644, 932, 1349,
                                       1951, 2823, 4085));
  EXPECT_THAT(std::vector(entries.begin(), entries.begin() + 6),
              ElementsAre(4096, 13824, 39304, 117656, 357912, 524288));
  const std::vector<GridLevel> tiny = grid_levels(test::kTinyGrid);
  EXPECT_EQ(tiny[2].scale, 5.75f);
  EXPECT_EQ(tiny[0].entries, 32u);  // 27 vertices
  EXPECT_EQ(tiny[3].first, 160u);
  EXPECT_TRUE(tiny[0].is_dense);
  EXPECT_FALSE(tiny[1].is_dense);
}

TEST(ColorField, positions_have_their_golden_entries) {
  EXPECT_THAT(first_corners(test::kTinyGrid, kMean), ElementsAre(13, 10, 4, 63));
  EXPECT_THAT(first_corners(test::kTinyGrid, {-8, 40, 3}), ElementsAre(16, 56, 27, 20));
  EXPECT_THAT(first_corners({}, kMean),
              ElementsAre(2425, 8317, 23649, 73086, 219004, 256396, 32257, 196609, 407066, 513678,
                          386649, 471578, 394219, 322883, 445685, 174266));
  EXPECT_THAT(first_corners({}, {2.5, -1, 0.75}),
              ElementsAre(2397, 8275, 23522, 70503, 213486, 228837, 312647, 427129, 175729, 464567,
                          457205, 79302, 227810, 367972, 286057, 521403));
}

TEST(ColorField, space_is_contracted_into_the_unit_cube) {
  expect_near(contract(kMean), {0.575, 0.45, 0.625}, 1e-15);
  expect_near(contract(glm::dvec3(2.5, -1, 0.75)), {0.867213595, 0.353114562, 0.610164079}, 1e-9);
  expect_near(contract(glm::dvec3(-8, 40, 3)), {0.4034015, 0.982992501, 0.536224438}, 1e-9);
}

TEST(ColorField, directions_have_their_golden_features) {
  std::array<double, kDirectionFeatures> sh;
  encode_direction(kDirection, sh.data());
  const std::array<double, 9> expected = {0.282094792, 1.00134456,  0.327123479,
                                          0.65174771,  2.98670525,  1.49907916,
                                          0.108723179, 0.975709507, -1.32240329};
  for (std::size_t i = 0; i < sh.size(); ++i) EXPECT_NEAR(sh[i], expected[i], 2e-8) << i;
}

TEST(ColorField, tiny_field_has_golden_features_and_outputs) {
  const ColorField field = test::tiny_field();
  const std::vector<double> features = test::grid_features(field, kMean);
  const std::array<double, 8> expected = {0.0492549133, -0.129748535, -0.113428835, -0.0995612866,
                                          0.578327788,  0.265860321,  0.0886857447, -0.51629346};
  ASSERT_EQ(features.size(), expected.size());
  for (std::size_t i = 0; i < features.size(); ++i)
    EXPECT_NEAR(features[i], expected[i], 1e-8) << i;
  expect_near(output(field, kMean, kDirection), {-0.251275908, -0.583596473, 0.40565009}, 1e-8);
  const glm::dvec3 far(-8, 40, 3);
  expect_near(output(field, far, glm::normalize(far - kEye)),
              {0.0827346823, 0.0745990502, -0.135618102}, 1e-8);
}

TEST(ColorField, published_field_has_golden_features_and_outputs) {
  // The scales of the levels are single precision, and libraries differ in their last bit.
  const ColorField field = test::published_field();
  const std::vector<double> features = test::grid_features(field, kMean);
  ASSERT_EQ(features.size(), 32u);
  EXPECT_NEAR(features[0], -0.0735626221, 1e-5);
  EXPECT_NEAR(features[31], -0.248527533, 1e-5);
  EXPECT_NEAR(std::accumulate(features.begin(), features.end(), 0.0), -0.227245188, 1e-4);
  expect_near(output(field, kMean, kDirection), {-0.0121607011, -0.0703391242, -0.0484961576},
              1e-5);
  const glm::dvec3 far(-8, 40, 3);
  expect_near(output(field, far, glm::normalize(far - kEye)),
              {0.180553242, 0.136779788, 0.213112869}, 1e-5);
}

std::array<double, 16> basis_at(const glm::dvec3& d) {
  std::array<double, 16> basis;
  sh_basis(d, basis.data());
  return basis;
}

TEST(ShDesign, directions_are_24_unit_vectors_that_make_the_projection_exact) {
  const auto directions = design_directions();
  for (std::size_t i = 0; i < 16; ++i) {
    for (std::size_t k = 0; k < 16; ++k) {
      double sum = 0;
      for (const glm::dvec3& d : directions) sum += basis_at(d)[i] * basis_at(d)[k];
      EXPECT_NEAR(sum * 4 * 3.14159265358979323846 / 24, i == k ? 1 : 0, 1e-12) << i << " " << k;
    }
  }
}

// Means of all places, few enough to be compared with double precision.
std::vector<glm::vec3> some_means(std::size_t count) {
  std::vector<glm::vec3> means = {glm::vec3(kMean), {2.5f, -1, 0.75f}, {-8, 40, 3}, {0, 0, 0}};
  for (std::size_t i = means.size(); i < count; ++i) {
    means.push_back(3.0f * glm::vec3(test::golden_value(3 * i), test::golden_value(3 * i + 1),
                                     test::golden_value(3 * i + 2)));
  }
  means.resize(count);
  return means;
}

void expect_equal_outputs(const ColorField& field, std::size_t count, double bound) {
  const FieldEvaluator evaluator(field);
  const std::vector<glm::vec3> means = some_means(count);
  std::vector<glm::vec3> out(count);
  evaluator.outputs(means, glm::vec3(kEye), out);
  for (std::size_t i = 0; i < count; ++i) {
    SCOPED_TRACE(i);
    const glm::dvec3 mean(means[i]);
    const glm::dvec3 expected = output(field, mean, glm::normalize(mean - kEye));
    expect_near(out[i], {expected.x, expected.y, expected.z}, bound);
  }
}

using FieldVectors = test::InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(InstructionSets, FieldVectors, testing::ValuesIn(test::kInstructionSets),
                         [](const auto& set) { return std::string(hwy::TargetName(set.param)); });

TEST_P(FieldVectors, outputs_equal_double_precision) {
  for (const std::size_t count : {0, 1, 15, 16, 17, 48, 49, 100})
    expect_equal_outputs(test::tiny_field(), count, 3e-6);
  // Positions in single precision decide about fractions of the finest cells.
  expect_equal_outputs(test::published_field(), 100, 1e-3);
}

TEST_P(FieldVectors, fit_has_golden_coefficients_and_differences) {
  const auto fit = [](const ColorField& field) {
    const FieldEvaluator evaluator(field);
    const glm::vec3 mean(kMean);
    std::vector<glm::vec3> sh(16);
    float rms = 0;
    evaluator.fit_sh({&mean, 1}, sh, {&rms, 1});
    return std::pair(sh, rms);
  };
  const auto [tiny, tiny_rms] = fit(test::tiny_field());
  expect_near(tiny[0], {-0.10179384, -0.581103378, 0.0263206627}, 1e-6);
  EXPECT_NEAR(tiny_rms, 0.0151107f, 1e-6f);
  const auto [published, published_rms] = fit(test::published_field());
  expect_near(published[0], {0.0497485686, -0.0327022828, -0.141994667}, 1e-3);
  EXPECT_NEAR(published_rms, 0.00595129f, 1e-4f);
  double norm = 0;
  for (std::size_t i = 9; i < 16; ++i) norm += glm::dot(glm::dvec3(tiny[i]), glm::dvec3(tiny[i]));
  EXPECT_NEAR(std::sqrt(norm), 0.115006319, 1e-6);
}

TEST_P(FieldVectors, fit_of_any_number_equals_the_projection_of_double_precision) {
  const ColorField field = test::tiny_field();
  const FieldEvaluator evaluator(field);
  const auto directions = design_directions();
  for (const std::size_t count : {0, 1, 7, 16, 33}) {
    const std::vector<glm::vec3> means = some_means(count);
    std::vector<glm::vec3> sh(16 * count);
    std::vector<float> rms(count);
    evaluator.fit_sh(means, sh, rms);
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < 16; ++k) {
        glm::dvec3 sum(0);
        for (const glm::dvec3& d : directions)
          sum += basis_at(d)[k] * kSh0 * output(field, glm::dvec3(means[i]), d);
        sum *= 4 * 3.14159265358979323846 / 24;
        expect_near(sh[16 * i + k], {sum.x, sum.y, sum.z}, 3e-6);
      }
    }
  }
}

// A network whose hidden layers are never cut off is quadratic in the direction, so the fit is
// exact.
TEST_P(FieldVectors, fit_of_a_quadratic_function_is_exact) {
  ColorField field = test::tiny_field();
  const NetworkShape shape = field.network();
  const auto inputs = static_cast<std::size_t>(shape.inputs());
  for (std::size_t k = 0; k < shape.third(); ++k) field.weights[k] = 0;
  for (std::size_t row = 0; row < 16; ++row) {
    for (std::size_t k = 8; k < 17; ++k)
      field.weights[row * inputs + k] = test::golden_value(row + k) / 16;
    field.weights[row * inputs + 17] = 8;  // an input that is 1
    field.weights[shape.second() + row * 16 + row] = 1;
  }
  const FieldEvaluator evaluator(field);
  const glm::vec3 mean(kMean);
  std::vector<glm::vec3> sh(16);
  float rms = 1;
  evaluator.fit_sh({&mean, 1}, sh, {&rms, 1});
  EXPECT_LT(rms, 3e-6f);
  glm::vec3 out;
  evaluator.outputs({&mean, 1}, glm::vec3(kEye), {&out, 1});
  const glm::vec3 exact = glm::max(static_cast<float>(kSh0) * out + 0.5f, glm::vec3(0));
  const glm::vec3 fitted =
      sh_color(3, glm::vec3(kDirection), [&](int i) { return sh[static_cast<std::size_t>(i)]; });
  expect_near(fitted, {exact.x, exact.y, exact.z}, 1e-5);
}

TEST_P(FieldVectors, positions_without_a_place_read_no_other_memory) {
  const FieldEvaluator evaluator(test::tiny_field());
  const std::vector<glm::vec3> means = {
      {NAN, 0, 0}, {INFINITY, 1, 1}, {-INFINITY, 0, 3e38f}, {3e38f, 3e38f, -3e38f}, {1e19f, 0, 0}};
  std::vector<glm::vec3> sh(16 * means.size()), out(means.size());
  std::vector<float> rms(means.size());
  evaluator.fit_sh(means, sh, rms);
  evaluator.outputs(means, glm::vec3(kEye), out);
  EXPECT_TRUE(std::isfinite(sh[4 * 16].x));
}

TEST(Half, rounds_to_the_nearest_half_and_back) {
  for (std::uint32_t bits = 0; bits < 0x10000; ++bits) {
    const auto half = static_cast<std::uint16_t>(bits);
    const float value = float_of_any_half(half);
    if (std::isnan(value)) continue;
    EXPECT_EQ(round_to_half(value), half);
    if ((half & 0x7fff) >= 0x7bff) continue;
    const float next = float_of_any_half(static_cast<std::uint16_t>(half + 1));
    const float middle = (value + next) / 2;
    EXPECT_EQ(round_to_half(middle), half + (half & 1)) << half;
    EXPECT_EQ(round_to_half(std::nextafter(middle, value)), half);
    EXPECT_EQ(round_to_half(std::nextafter(middle, next)), half + 1);
  }
  EXPECT_EQ(round_to_half(65519.99f), 0x7bff);
  EXPECT_EQ(round_to_half(65520), 0x7c00);
  EXPECT_EQ(round_to_half(-1e9f), 0xfc00);
  EXPECT_TRUE(std::isnan(float_of_any_half(round_to_half(NAN))));
}

}  // namespace
}  // namespace qs
