// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

#include "app/framing/first_view.h"

namespace qs {
namespace {

double degrees_between(glm::dvec3 a, glm::dvec3 b) {
  return glm::degrees(std::acos(std::min(1.0, glm::dot(a, b) / (glm::length(a) * glm::length(b)))));
}

// Cameras on a ring around the y axis of a turned world, looking at its origin from above, each
// rolled by a little.
std::vector<Camera> ring(const glm::dmat3& turn, int count, double height, double roll) {
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const double angle = i * 2 * glm::pi<double>() / count;
    const glm::dvec3 up(roll * (i % 2 == 0 ? 1 : -1) * std::cos(angle), -1,
                        roll * (i % 2 == 0 ? 1 : -1) * std::sin(angle));
    cameras.push_back(look_at(turn * glm::dvec3(4 * std::sin(angle), -height, -4 * std::cos(angle)),
                              glm::dvec3(0), turn * up, 1, 64, 48));
  }
  return cameras;
}

TEST(CamerasUp, is_perpendicular_to_their_x_axes_where_the_mean_is_not_up) {
  const glm::dmat3 turn = glm::mat3_cast(glm::angleAxis(0.7, glm::normalize(glm::dvec3(1, 2, 3))));
  const glm::dvec3 up = turn * glm::dvec3(0, -1, 0);
  EXPECT_LT(degrees_between(cameras_up(ring(turn, 24, 3, 0), {1, 0, 0}), up), 0.01);
  EXPECT_LT(degrees_between(cameras_up(ring(turn, 24, 3, 0.05), {1, 0, 0}), up), 1);
  // A quarter of a ring that looks down: the mean leans back by tens of degrees.
  std::vector<Camera> quarter = ring(turn, 24, 3, 0);
  quarter.resize(6);
  EXPECT_LT(degrees_between(cameras_up(quarter, {1, 0, 0}), up), 0.01);
  glm::dvec3 mean(0);
  for (const Camera& camera : quarter)
    mean -= glm::dvec3(camera.view_from_world[0][1], camera.view_from_world[1][1],
                       camera.view_from_world[2][1]);
  EXPECT_GT(degrees_between(mean, up), 20);
}

TEST(CamerasUp, is_the_mean_of_parallel_cameras_and_the_other_axis_without_a_mean) {
  std::vector<Camera> cameras;
  for (const double x : {0.0, 1.0, 2.0})
    cameras.push_back(look_at({x, 0, 0}, {x, 1, 5}, {0, -1, 0}, 1, 64, 48));
  const glm::dvec3 mean = glm::normalize(glm::dvec3(0, -5, 1));
  EXPECT_LT(glm::distance(cameras_up(cameras, {1, 0, 0}), mean), 1e-9);
  EXPECT_EQ(cameras_up({}, {1, 0, 0}), glm::dvec3(1, 0, 0));
}

TEST(CamerasTarget, is_where_the_optical_axes_meet) {
  std::vector<Camera> cameras;
  const glm::dvec3 target(1, -2, 3);
  for (int i = 0; i < 5; ++i)
    cameras.push_back(look_at({i, 0.2 * i * i, -3}, target, {0, -1, 0}, 1, 64, 48));
  ASSERT_TRUE(cameras_target(cameras));
  EXPECT_LT(glm::distance(*cameras_target(cameras), target), 1e-9);
  // Axes that pass each other: half way between them.
  cameras = {look_at({0, 0, 0}, {0, 0, 1}, {0, -1, 0}, 1, 64, 48),
             look_at({-3, 2, 5}, {3, 2, 5}, {0, -1, 0}, 1, 64, 48)};
  EXPECT_LT(glm::distance(*cameras_target(cameras), glm::dvec3(0, 1, 5)), 1e-9);
}

TEST(CamerasTarget, needs_cameras_that_look_at_it) {
  EXPECT_FALSE(cameras_target({}));
  std::vector<Camera> parallel, outward;
  for (int i = 0; i < 6; ++i) {
    parallel.push_back(look_at({i, 0, 0}, {i, 0, 1}, {0, -1, 0}, 1, 64, 48));
    const glm::dvec3 away(std::sin(i), 0, std::cos(i));
    outward.push_back(look_at(away, 2.0 * away, {0, -1, 0}, 1, 64, 48));
  }
  EXPECT_FALSE(cameras_target(parallel));
  EXPECT_FALSE(cameras_target(outward));
}

TEST(CamerasFraming, is_from_the_place_of_one_of_them_at_what_they_look_at) {
  std::vector<Camera> cameras;
  const glm::dvec3 target(1, 2, 3), up(0, -1, 0);
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 eye = target + glm::dvec3(3 * std::sin(i), -1, 3 * std::cos(i));
    cameras.push_back(look_at(eye, target, up, 0.8, 64, 48));
  }
  const std::optional<Framing> framing = framing_of(cameras, up);
  ASSERT_TRUE(framing);
  EXPECT_LT(glm::distance(framing->target, target), 1e-9);
  EXPECT_NEAR(framing->vertical_fov, 0.8, 1e-9);
  const auto is_at = [&](const Camera& camera) {
    return glm::distance(camera.position(), framing->eye) < 1e-9;
  };
  EXPECT_TRUE(std::any_of(cameras.begin(), cameras.end(), is_at));
  EXPECT_LT(glm::distance(framed_camera(*framing, 90, 160).position(), framing->eye), 1e-9);
  // Cameras far away, which structure from motion placed wrong, do not move the target.
  std::vector<Camera> with_outliers = cameras;
  for (const double away : {1700.0, -9e4})
    with_outliers.push_back(look_at({away, away, 5}, {0, away, 8}, up, 0.8, 64, 48));
  const std::optional<Framing> steady = framing_of(with_outliers, up);
  ASSERT_TRUE(steady);
  EXPECT_LT(glm::distance(steady->target, target), 1e-9);
  EXPECT_EQ(steady->eye, framing->eye);
  // Cameras that look outward have no target, so the camera in the middle keeps its own view.
  for (Camera& camera : cameras)
    camera = look_at(camera.position(), 2.0 * camera.position() - target, up, 1, 64, 48);
  cameras.push_back(look_at(target + glm::dvec3(0, -1, 0), {9, 1, 3}, up, 1, 64, 48));
  const std::optional<Framing> outward = framing_of(cameras, up);
  ASSERT_TRUE(outward);
  EXPECT_LT(glm::distance(outward->eye, cameras.back().position()), 1e-9);
  EXPECT_GT(glm::dot(outward->target - outward->eye, glm::dvec3(1, 0, 0)), 0.1);
  EXPECT_FALSE(framing_of({}, up));
}

}  // namespace
}  // namespace qs
