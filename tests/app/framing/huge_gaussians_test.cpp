// SPDX-License-Identifier: MIT
#include <cmath>

#include <gtest/gtest.h>

#include "app/framing/first_view.h"
#include "app/framing/scene_box.h"
#include "app/framing/subject.h"
#include "raster/api/renderer.h"
#include "support/built_scenes.h"
#include "support/pool.h"

namespace qs {
namespace {

// A ball of radius 1 on a floor, and `count` Gaussians of standard deviation `sigma` around them.
GaussianCloud scene_with(int count, float sigma) {
  test::SceneBuilder builder(3);
  builder.disc(3000, {0, 1, 0}, {0, -1, 0}, 2);
  builder.ball(3000, {0, 0, 0}, 1);
  builder.paint = glm::vec3(1);
  for (int i = 0; i < count; ++i)
    builder.piece({0, 0.1f * static_cast<float>(i), 0}, {0, 0, 1}, sigma / 1.5f, glm::vec3(1));
  return builder.cloud;
}

TEST(HugeGaussians, are_those_larger_than_the_scene) {
  const GaussianCloud plain = scene_with(0, 1);
  const float length = scene_length(plain);
  EXPECT_GT(length, 3);
  EXPECT_LT(length, 6);
  EXPECT_EQ(count_huge(plain), 0u);
  EXPECT_EQ(count_huge(scene_with(3, 0.9f * length)), 0u);
  GaussianCloud cloud = scene_with(3, 270);
  EXPECT_EQ(count_huge(cloud), 3u);
  EXPECT_EQ(drop_huge(cloud), 3u);
  EXPECT_EQ(cloud.size(), plain.size());
  EXPECT_EQ(cloud.positions, plain.positions);
  EXPECT_EQ(drop_huge(cloud), 0u);
}

TEST(HugeGaussians, are_not_found_in_scenes_without_extent) {
  EXPECT_EQ(count_huge(GaussianCloud()), 0u);
  test::SceneBuilder one(3);
  one.piece({1, 2, 3}, {0, 0, 1}, 50, glm::vec3(1));
  EXPECT_EQ(count_huge(one.cloud), 0u);
  one.cloud.log_scales[0] = glm::vec3(-INFINITY);
  EXPECT_EQ(count_huge(one.cloud), 0u);
}

TEST(HugeGaussians, change_neither_the_sample_nor_the_first_view) {
  const GaussianCloud plain = scene_with(0, 1), covered = scene_with(5, 270);
  EXPECT_EQ(sample_of(covered, 50'000).gaussians.positions,
            sample_of(plain, 50'000).gaussians.positions);
  const Framing expected = choose_framing(plain, {}, test::pool());
  const Framing framing = choose_framing(covered, {}, test::pool());
  EXPECT_EQ(framing.eye, expected.eye);
  EXPECT_EQ(framing.target, expected.target);
}

TEST(HugeGaussians, have_a_sentence) {
  EXPECT_EQ(huge_text(1), "1 Gaussian is larger than the scene");
  EXPECT_EQ(huge_text(1234), "1,234 Gaussians are larger than the scene");
}

}  // namespace
}  // namespace qs
