// SPDX-License-Identifier: MIT
#include <cmath>
#include <limits>
#include <random>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include "io/scene/compact/compact_model.h"
#include "support/oracle.h"

namespace qs::test {
namespace {

// R' diag(scale^2) R'^T with R' = (1 - s^2) I + s^2 R(u) for q = s u.
glm::dmat3 raw_covariance(const glm::vec4& quaternion, const glm::vec3& scale) {
  const glm::dvec4 q(quaternion);
  const double square = glm::dot(q, q);
  glm::dmat3 r(1);
  if (square > 0) {
    const glm::dquat unit = glm::normalize(glm::dquat(q.x, q.y, q.z, q.w));
    r = (1 - square) * glm::dmat3(1) + square * glm::mat3_cast(unit);
  }
  for (int axis = 0; axis < 3; ++axis) r[axis] *= static_cast<double>(scale[axis]);
  return r * glm::transpose(r);
}

void expect_shape(const glm::vec4& quaternion, const glm::vec3& scale) {
  const ShapeOfGaussian shape = shape_of_raw_rotation(quaternion, scale);
  EXPECT_NEAR(glm::length(glm::dquat(shape.rotation)), 1, 1e-6);
  const glm::dmat3 expected = raw_covariance(quaternion, scale);
  const glm::dmat3 actual =
      covariance(glm::normalize(glm::dquat(shape.rotation)), glm::exp(glm::dvec3(shape.log_scale)));
  const double largest = std::max({expected[0][0], expected[1][1], expected[2][2]});
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row)
      EXPECT_NEAR(actual[column][row], expected[column][row], 3e-6 * largest) << column << row;
  }
}

TEST(RawRotation, keeps_the_covariance_of_quaternions_of_any_length) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE(i);
    glm::vec4 q(normal(random), normal(random), normal(random), normal(random));
    if (i % 2 == 0) q *= (1 + 0.03f * normal(random)) / glm::length(q);
    const glm::vec3 scale = glm::exp(glm::vec3(normal(random), normal(random), normal(random)) *
                                     (i % 3 == 0 ? 4.0f : 1.0f));
    expect_shape(q, scale);
  }
}

TEST(RawRotation, unit_quaternions_and_their_scales_stay) {
  const ShapeOfGaussian shape = shape_of_raw_rotation({0.5f, 0.5f, -0.5f, 0.5f}, {1, 2, 3});
  EXPECT_NEAR(shape.log_scale.x, 0, 1e-7);
  EXPECT_NEAR(shape.log_scale.y, std::log(2), 1e-6);
  EXPECT_NEAR(shape.log_scale.z, std::log(3), 1e-6);
  EXPECT_NEAR(std::abs(shape.rotation.w), 0.5, 1e-6);
}

TEST(RawRotation, flat_thin_and_empty_shapes_have_a_rotation) {
  const glm::vec4 q(0.9f, 0.3f, -0.2f, 0.1f);
  for (const glm::vec3& scale :
       {glm::vec3(1, 2, 0), glm::vec3(0, 2, 3), glm::vec3(1, 0, 3), glm::vec3(0, 0, 2),
        glm::vec3(5, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0), glm::vec3(-1, 2, -3),
        glm::vec3(1e-6f, 1, 1e3f), glm::vec3(1e-12f, 1e-12f, 1e-12f)}) {
    SCOPED_TRACE(scale.x);
    expect_shape(q, scale);
  }
  expect_shape(glm::vec4(0), {1, 2, 3});  // no rotation at all
  expect_shape(glm::vec4(0, 2, 0, 0), {1, 2, 3});
  EXPECT_EQ(shape_of_raw_rotation(q, {1, 2, 0}).log_scale.z,
            -std::numeric_limits<float>::infinity());
}

TEST(RawRotation, values_that_are_no_numbers_give_no_rotation) {
  EXPECT_TRUE(std::isnan(shape_of_raw_rotation({NAN, 0, 0, 1}, {1, 1, 1}).rotation.w));
  EXPECT_TRUE(std::isnan(shape_of_raw_rotation({1, 0, 0, 0}, {1, INFINITY, 1}).rotation.w));
}

}  // namespace
}  // namespace qs::test
