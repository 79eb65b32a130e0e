// SPDX-License-Identifier: MIT
#include "raster/scene/transform.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include "support/oracle.h"
#include "support/scenes.h"

namespace qs::test {
namespace {

glm::dvec3 sh_color(const GaussianCloud& cloud, std::size_t i, const glm::dvec3& direction) {
  return sh_sum(cloud, i, cloud.sh_degree, direction);
}

// `turn` is the orthogonal part of `matrix`.
void expect_moved(const glm::dmat4& matrix, const glm::dmat3& turn) {
  const GaussianCloud cloud = random_cloud(30, 3, 4);
  GaussianCloud moved = cloud;
  const Transform transform(matrix);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    transform.apply(moved, i);
    const glm::dvec3 position = matrix * glm::dvec4(glm::dvec3(cloud.positions[i]), 1);
    EXPECT_LT(glm::distance(glm::dvec3(moved.positions[i]), position),
              1e-5 * (1 + glm::length(position)));
    const glm::dmat3 linear(matrix);
    const glm::dmat3 expected = linear * covariance(cloud, i) * glm::transpose(linear);
    const glm::dmat3 actual = covariance(moved, i);
    const double largest = std::max({expected[0][0], expected[1][1], expected[2][2]});
    for (int c = 0; c < 3; ++c) EXPECT_LT(glm::distance(actual[c], expected[c]), 1e-5 * largest);
    const glm::dvec3 direction = glm::normalize(glm::dvec3(0.3, -0.7, 0.2 + 0.1 * double(i)));
    EXPECT_LT(glm::distance(sh_color(moved, i, turn * direction), sh_color(cloud, i, direction)),
              1e-5);
  }
}

const glm::dvec3 kAxis = glm::normalize(glm::dvec3(1, -2, 0.5));

TEST(Covariance, is_the_one_that_was_set) {
  const GaussianCloud cloud = random_cloud(50, 0, 12);
  GaussianCloud set = cloud;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dmat3 expected = covariance(cloud, i);
    set_covariance(set, i, expected);
    const glm::dmat3 actual = covariance(set, i);
    const double largest = std::max({expected[0][0], expected[1][1], expected[2][2]});
    for (int c = 0; c < 3; ++c) EXPECT_LT(glm::distance(actual[c], expected[c]), 1e-5 * largest);
  }
  set_covariance(set, 0, glm::dmat3(4, 0, 0, 0, 0, 0, 0, 0, -1e-9));
  EXPECT_NEAR(set.log_scales[0].x, std::log(2.0), 1e-6);
  EXPECT_EQ(set.log_scales[0].y, -INFINITY);
  EXPECT_EQ(set.log_scales[0].z, -INFINITY);
}

TEST(Transform, turned_and_scaled_scene_looks_the_same_from_the_turned_side) {
  const glm::dmat4 turn = glm::rotate(glm::dmat4(1), 1.1, kAxis);
  const glm::dmat4 matrix = glm::translate(glm::dmat4(1), glm::dvec3(3, -4, 5)) * turn *
                            glm::scale(glm::dmat4(1), glm::dvec3(2.5));
  EXPECT_TRUE(Transform(matrix).is_similarity());
  expect_moved(matrix, glm::dmat3(turn));
}

TEST(Transform, stretching_transforms_covariances) {
  const glm::dmat4 turn = glm::rotate(glm::dmat4(1), -0.6, kAxis);
  const glm::dmat4 matrix = turn * glm::scale(glm::dmat4(1), glm::dvec3(2, 0.5, 1));
  EXPECT_FALSE(Transform(matrix).is_similarity());
  expect_moved(matrix, glm::dmat3(turn));
}

TEST(Transform, mirroring_turns_sh_too) {
  const glm::dmat4 mirror = glm::scale(glm::dmat4(1), glm::dvec3(-1, 1, 1));
  EXPECT_FALSE(Transform(mirror).is_similarity());
  expect_moved(mirror, glm::dmat3(mirror));
}

TEST(Transform, flattening_matrices_are_not_invertible) {
  EXPECT_TRUE(Transform::is_invertible(glm::dmat4(1)));
  EXPECT_TRUE(Transform::is_invertible(glm::scale(glm::dmat4(1), glm::dvec3(1e-3))));
  EXPECT_FALSE(Transform::is_invertible(glm::dmat4(0)));
  EXPECT_FALSE(Transform::is_invertible(glm::scale(glm::dmat4(1), glm::dvec3(1, 1, 0))));
  EXPECT_FALSE(Transform::is_invertible(glm::scale(glm::dmat4(1), glm::dvec3(INFINITY))));
}

}  // namespace
}  // namespace qs::test
