// SPDX-License-Identifier: MIT
#include "app/framing/up_axis.h"

#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

#include "app/framing/first_view.h"
#include "io/cloud/axes.h"
#include "io/scene/reader.h"
#include "support/built_scenes.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace qs {
namespace {

constexpr glm::dvec3 kConvention{0, -1, 0};

double angle_between(glm::dvec3 a, glm::dvec3 b) {
  return glm::degrees(std::acos(std::min(1.0, glm::dot(a, b) / (glm::length(a) * glm::length(b)))));
}

glm::dvec3 up_of(const GaussianCloud& cloud) {
  const CloudSample sample = sample_of(cloud, 50'000);
  return estimate_up(sample, find_subject(sample, kSceneDensity), kConvention).up;
}

TEST(UpAxis, is_the_normal_of_a_tilted_floor_under_objects_and_floaters) {
  for (const glm::dvec3 up : {glm::dvec3(0, -1, 0), glm::dvec3(0.3, -1, 0.1),
                              glm::dvec3(0, -0.877, -0.481), glm::dvec3(-0.6, -1, 0.5)}) {
    for (const float scale : {0.01f, 1.0f, 500.0f}) {
      test::SceneBuilder builder(3);
      const glm::vec3 normal(glm::normalize(up)), middle(3 * scale, scale, -2 * scale);
      builder.disc(6000, middle, normal, 2 * scale);
      builder.ball(4000, middle + 0.5f * scale * normal, 0.5f * scale);
      builder.floaters(300, middle, 8 * scale, 0.2f * scale);
      EXPECT_LT(angle_between(up_of(builder.cloud), up), 2) << up.x << ' ' << scale;
    }
  }
}

TEST(UpAxis, is_the_normal_of_a_bare_floor_under_dense_things_and_below_a_roof) {
  const glm::quat lean = glm::angleAxis(0.3f, glm::normalize(glm::vec3(1, 0, 0.4f)));
  const glm::dvec3 up(lean * glm::vec3(0, -1, 0));
  test::SceneBuilder kitchen(3);
  kitchen.room({2.5f, 1.3f, 3}, true);
  kitchen.box(3000, {0, -0.4f, 0}, {0.6f, 0.4f, 0.9f});
  kitchen.ball(3000, {0, -1.1f, 0}, 0.3f);
  kitchen.turn(lean);
  EXPECT_LT(angle_between(up_of(kitchen.cloud), up), 2);
  test::SceneBuilder house(3);
  house.room({4, 2.5f, 3}, false);
  for (const float side : {-1.0f, 1.0f})
    house.rectangle(6000, {0, -6, 1.5f * side}, {4.5f, 0, 0}, {0, -1, -1.6f * side});
  house.turn(lean);
  EXPECT_LT(angle_between(up_of(house.cloud), up), 2);
}

TEST(UpAxis, is_the_convention_s_at_a_wall_and_around_a_ball) {
  test::SceneBuilder wall(4);
  wall.rectangle(5000, {0, 0, 3}, {2, 0, 0}, {0, 1, 0});
  EXPECT_EQ(up_of(wall.cloud), kConvention);
  test::SceneBuilder ball(5);
  ball.ball(5000, {1, 2, 3}, 1);
  EXPECT_EQ(up_of(ball.cloud), kConvention);
}

TEST(UpAxis, is_perpendicular_to_walls_without_a_floor) {
  const glm::quat lean = glm::angleAxis(glm::radians(15.0f), glm::vec3(0, 0, 1));
  const glm::vec3 up = lean * glm::vec3(0, -1, 0), aside = lean * glm::vec3(1, 0, 0);
  test::SceneBuilder walls(6);
  walls.rectangle(4000, {0, 0, 2}, 2.0f * aside, up);
  walls.rectangle(3000, 2.0f * aside, {0, 0, 2}, up);
  EXPECT_LT(angle_between(up_of(walls.cloud), glm::dvec3(up)), 2);
}

// The normal was fitted to the data set's own points, from which no Gaussian was made here.
TEST(UpAxis, of_trained_scenes_is_within_five_degrees_of_the_plane_of_their_points) {
  for (const char* name : {"scenes/plush.spz", "scenes/plush_big.spz", "scenes/plush_small.spz"}) {
    QS_NEEDS_SHARED(name);
    const Scene scene = read_scene(test::shared_path(name), test::pool());
    EXPECT_LT(angle_between(up_of(scene.cloud), {0.002, -0.877, -0.481}), 5) << name;
  }
}

TEST(UpAxis, of_clouds_without_surfaces_is_the_convention_s) {
  EXPECT_EQ(up_of(GaussianCloud()), kConvention);
  EXPECT_EQ(up_of(test::random_cloud(50, 0, 1)), kConvention);
  GaussianCloud equal = test::random_cloud(500, 0, 1);
  for (glm::vec3& p : equal.positions) p = glm::vec3(1, 2, 3);
  EXPECT_EQ(up_of(equal), kConvention);
}

UpEstimate estimate_of(const GaussianCloud& cloud) {
  const CloudSample sample = sample_of(cloud, 50'000);
  return estimate_up(sample, find_subject(sample, kSceneDensity), kConvention);
}

bool upside_down(const GaussianCloud& cloud) { return estimate_of(cloud).upside_down; }

GaussianCloud turned_over(GaussianCloud cloud) {
  flip_axes(cloud, 0, cloud.size(), kTurnAboutX);
  return cloud;
}

TEST(UpsideDown, is_a_scene_that_hangs_from_its_floor) {
  test::SceneBuilder things(3);
  things.disc(6000, {0, 0, 0}, {0, -1, 0}, 2);
  things.ball(4000, {0, -0.5f, 0}, 0.5f);
  things.floaters(300, {0, 0, 0}, 8, 0.2f);
  EXPECT_FALSE(upside_down(things.cloud));
  EXPECT_TRUE(upside_down(turned_over(things.cloud)));
  test::SceneBuilder garden(3);
  garden.disc(6000, {0, 0, 0}, {0, -1, 0}, 5);
  garden.trees(8, 3.5f, 0.8f);
  EXPECT_FALSE(upside_down(garden.cloud));
  EXPECT_TRUE(upside_down(turned_over(garden.cloud)));
}

TEST(UpsideDown, is_not_said_of_rooms_walls_and_balls) {
  for (const bool closed : {false, true}) {
    test::SceneBuilder room(3);
    room.room({2.5f, 1.3f, 3}, closed);
    EXPECT_FALSE(upside_down(room.cloud)) << closed;
    room.box(3000, {0, -0.4f, 0}, {0.6f, 0.4f, 0.9f});
    EXPECT_FALSE(upside_down(room.cloud)) << closed;
  }
  test::SceneBuilder wall(4);
  wall.rectangle(5000, {0, 0, 3}, {2, 0, 0}, {0, 1, 0});
  EXPECT_FALSE(upside_down(wall.cloud));
  test::SceneBuilder ball(5);
  ball.ball(5000, {1, 2, 3}, 1);
  EXPECT_FALSE(upside_down(ball.cloud));
  EXPECT_FALSE(upside_down(GaussianCloud()));
}

TEST(UpsideDown, is_open_without_a_floor_and_decided_with_one) {
  test::SceneBuilder ball(5);
  ball.ball(5000, {1, 2, 3}, 1);
  EXPECT_FALSE(estimate_of(ball.cloud).has_floor);
  EXPECT_FALSE(estimate_of(GaussianCloud()).has_floor);
  test::SceneBuilder things(3);
  things.disc(6000, {0, 0, 0}, {0, -1, 0}, 2);
  things.ball(4000, {0, -0.5f, 0}, 0.5f);
  EXPECT_TRUE(estimate_of(things.cloud).has_floor);
  EXPECT_TRUE(estimate_of(turned_over(things.cloud)).has_floor);
  const Framing open = choose_framing(ball.cloud, {}, test::pool());
  EXPECT_TRUE(open.up_is_assumed);
  EXPECT_FALSE(choose_framing(ball.cloud, glm::dvec3(0, 0, 1), test::pool()).up_is_assumed);
  EXPECT_FALSE(choose_framing(things.cloud, {}, test::pool()).up_is_assumed);
}

TEST(UpsideDown, is_seen_in_trained_scenes) {
  const auto check = [](const std::filesystem::path& path) {
    const GaussianCloud cloud = read_scene(path, test::pool()).cloud;
    EXPECT_FALSE(upside_down(cloud)) << path;
    EXPECT_TRUE(upside_down(turned_over(cloud))) << path;
  };
  check(test::source_path("assets/plush.ply"));
  for (const char* name : {"scenes/plush.spz", "scenes/plush_big.spz"}) {
    QS_NEEDS_SHARED(name);
    check(test::shared_path(name));
  }
}

TEST(UpsideDown, is_open_for_a_trained_object_without_a_floor) {
  const char* const name = "scenes/wild/playcanvas_guitar.compressed.ply";
  QS_NEEDS_SHARED(name);
  const GaussianCloud cloud = read_scene(test::shared_path(name), test::pool()).cloud;
  for (const GaussianCloud& guitar : {cloud, turned_over(cloud)}) {
    EXPECT_FALSE(estimate_of(guitar).has_floor);
    EXPECT_FALSE(estimate_of(guitar).upside_down) << "nothing is claimed";
  }
}

TEST(PrincipalAxes, rebuild_the_matrix) {
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 50; ++round) {
    glm::dmat3 half(0);
    for (int i = 0; i < 9; ++i) half[i / 3][i % 3] = normal(random) * (i < 3 ? 1e-3 : 1.0);
    if (round % 5 == 0) half[1] = half[0];  // singular
    const glm::dmat3 matrix = half * glm::transpose(half);
    const PrincipalAxes axes = principal_axes(matrix);
    EXPECT_LE(axes.value[0], axes.value[1]);
    EXPECT_LE(axes.value[1], axes.value[2]);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(glm::length(axes.axis[i]), 1, 1e-12);
      EXPECT_LT(glm::distance(matrix * axes.axis[i], axes.value[i] * axes.axis[i]), 1e-11);
    }
  }
}

}  // namespace
}  // namespace qs
