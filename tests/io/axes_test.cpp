// SPDX-License-Identifier: MIT
#include "io/scene/axes.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include "support/oracle.h"
#include "support/scenes.h"

namespace qs::test {
namespace {

const std::array<AxisSigns, 8> kAllSigns = {{{1, 1, 1},
                                             {-1, 1, 1},
                                             {1, -1, 1},
                                             {1, 1, -1},
                                             {-1, -1, 1},
                                             {-1, 1, -1},
                                             {1, -1, -1},
                                             {-1, -1, -1}}};

glm::dmat3 matrix(AxisSigns signs) { return {signs.x, 0, 0, 0, signs.y, 0, 0, 0, signs.z}; }

glm::dvec3 color(const GaussianCloud& cloud, std::size_t i, const glm::dvec3& direction) {
  return sh_sum(cloud, i, cloud.sh_degree, direction);
}

TEST(Axes, flipped_scene_looks_the_same_from_the_flipped_side) {
  const GaussianCloud cloud = random_cloud(20, 3, 1);
  for (const AxisSigns signs : kAllSigns) {
    SCOPED_TRACE(testing::Message() << signs.x << ' ' << signs.y << ' ' << signs.z);
    GaussianCloud flipped = cloud;
    flip_axes(flipped, 0, flipped.size(), signs);
    const glm::dmat3 flip = matrix(signs);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      EXPECT_EQ(glm::dvec3(flipped.positions[i]), flip * glm::dvec3(cloud.positions[i]));
      const glm::dmat3 expected = flip * covariance(cloud, i) * flip;
      const glm::dmat3 actual = covariance(flipped, i);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(glm::distance(actual[c], expected[c]), 0,
                    1e-6 * (1 + glm::length(expected[c])));
      }
      const glm::dvec3 direction = glm::normalize(glm::dvec3(0.3, -0.7, 0.2 + 0.1 * double(i)));
      EXPECT_NEAR(glm::distance(color(flipped, i, flip * direction), color(cloud, i, direction)), 0,
                  1e-5);
    }
  }
}

TEST(Axes, flipping_twice_changes_nothing) {
  const GaussianCloud cloud = random_cloud(20, 2, 2);
  for (const AxisSigns signs : kAllSigns) {
    GaussianCloud flipped = cloud;
    flip_axes(flipped, 0, 20, signs);
    flip_axes(flipped, 0, 20, signs);
    EXPECT_EQ(flipped.positions, cloud.positions);
    EXPECT_EQ(flipped.rotations, cloud.rotations);
    EXPECT_EQ(flipped.sh, cloud.sh);
  }
}

TEST(Axes, the_letters_of_a_frame_give_its_signs) {
  for (std::size_t number = 0; number < kAxes.size(); ++number) {
    const std::string_view name = kAxes[number];
    const AxisSigns signs = signs_to_rdf(number);
    EXPECT_EQ(signs.x, name[0] == 'R' ? 1 : -1) << name;
    EXPECT_EQ(signs.y, name[1] == 'D' ? 1 : -1) << name;
    EXPECT_EQ(signs.z, name[2] == 'F' ? 1 : -1) << name;
  }
}

TEST(Axes, only_the_given_range_is_touched) {
  const GaussianCloud cloud = random_cloud(3, 0, 3);
  GaussianCloud flipped = cloud;
  flip_axes(flipped, 1, 2, kTurnAboutZ);
  EXPECT_EQ(flipped.positions[0], cloud.positions[0]);
  EXPECT_EQ(flipped.positions[1], cloud.positions[1] * glm::vec3(-1, -1, 1));
  EXPECT_EQ(flipped.positions[2], cloud.positions[2]);
}

}  // namespace
}  // namespace qs::test
