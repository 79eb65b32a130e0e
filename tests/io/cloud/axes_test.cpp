// SPDX-License-Identifier: MIT
#include "io/cloud/axes.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include "io/scene/reader.h"
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

TEST(Axes, are_24_right_handed_frames_and_4_mirrored_parallel_ones) {
  int count = 0;
  for (const char a : std::string("RLDUFB")) {
    for (const char b : std::string("RLDUFB")) {
      for (const char c : std::string("RLDUFB")) {
        const std::string name = {a, b, c};
        if (!is_axes(name)) continue;
        ++count;
        const glm::dmat3 turn = rdf_from(name);
        const bool parallel = std::find(kAxes.begin(), kAxes.end(), name) != kAxes.end();
        EXPECT_EQ(std::abs(glm::determinant(turn)), 1) << name;
        EXPECT_TRUE(parallel || glm::determinant(turn) == 1) << name;
      }
    }
  }
  EXPECT_EQ(count, 28);
  for (const char* bad : {"", "RD", "RDFF", "RRF", "rdf", "RDX", "LFU", "XYZ"})
    EXPECT_FALSE(is_axes(bad)) << bad;
}

TEST(Axes, a_frame_with_z_up_stands_upright_and_keeps_its_look) {
  Scene scene;
  scene.cloud = random_cloud(20, 3, 1);
  scene.vertical_axis = "z";
  const GaussianCloud before = scene.cloud;
  assume_axes(scene, "RFU");
  EXPECT_EQ(scene.axes, "RFU");
  EXPECT_EQ(scene.vertical_axis, "") << "up is -y now";
  const glm::dmat3 turn = rdf_from("RFU");
  EXPECT_EQ(turn * glm::dvec3(0, 0, 1), glm::dvec3(0, -1, 0));
  EXPECT_EQ(turn * glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1));
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(
        glm::distance(glm::dvec3(scene.cloud.positions[i]), turn * glm::dvec3(before.positions[i])),
        0, 1e-5);
    const glm::dmat3 expected = turn * covariance(before, i) * glm::transpose(turn);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(glm::distance(covariance(scene.cloud, i)[c], expected[c]), 0,
                  1e-5 * (1 + glm::length(expected[c])));
    const glm::dvec3 direction = glm::normalize(glm::dvec3(0.3, -0.7, 0.2 + 0.1 * double(i)));
    EXPECT_NEAR(glm::distance(color(scene.cloud, i, turn * direction), color(before, i, direction)),
                0, 1e-4);
  }
  assume_axes(scene, "RDF");
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_NEAR(glm::distance(scene.cloud.positions[i], before.positions[i]), 0, 1e-5);
}

}  // namespace
}  // namespace qs::test
