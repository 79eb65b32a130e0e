// SPDX-License-Identifier: MIT
#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

#include "app/framing/scene_box.h"
#include "app/framing/up_axis.h"

namespace qs {
namespace {

// Gaussians spread over a cube of side `size` around `center`.
GaussianCloud cube(float size, glm::vec3 center, std::size_t count = 2000) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> offset(-0.5f, 0.5f);
  GaussianCloud cloud;
  cloud.resize(count, 0);
  for (glm::vec3& p : cloud.positions)
    p = center + size * glm::vec3(offset(random), offset(random), offset(random));
  for (glm::vec3& s : cloud.log_scales) s = glm::vec3(std::log(1e-3f * size));
  for (glm::quat& r : cloud.rotations) r = glm::quat(1, 0, 0, 0);
  for (float& o : cloud.opacity_logits) o = 2;
  for (glm::vec3& c : cloud.sh) c = glm::vec3(0.5f);
  return cloud;
}

glm::dvec2 project(const Camera& camera, glm::dvec3 point) {
  const glm::dvec3 view = camera.view_from_world * glm::dvec4(point, 1);
  EXPECT_GT(view.z, camera.near_depth);
  return camera.center_px + camera.focal_px * glm::dvec2(view) / view.z;
}

// Every corner of the core box is in the picture, and the box fills a good part of it.
void expect_framed(const Camera& camera, const SceneBox& box) {
  glm::dvec2 low(1e9), high(-1e9);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 point(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                           corner & 4 ? box.high.z : box.low.z);
    const glm::dvec2 px = project(camera, point);
    low = glm::min(low, px);
    high = glm::max(high, px);
  }
  EXPECT_GE(low.x, 0);
  EXPECT_GE(low.y, 0);
  EXPECT_LE(high.x, camera.width - 1);
  EXPECT_LE(high.y, camera.height - 1);
  EXPECT_GT((high.y - low.y) / camera.height + (high.x - low.x) / camera.width, 0.6);
}

TEST(Framing, shows_scenes_of_any_size_whole) {
  for (const float size : {0.001f, 0.1f, 1.0f, 1000.0f, 1e6f}) {
    const GaussianCloud cloud = cube(size, glm::vec3(3 * size, -size, 2 * size));
    for (const glm::ivec2 picture : {glm::ivec2(1280, 720), glm::ivec2(300, 900)}) {
      expect_framed(frame_cloud(cloud, world_up(""), picture.x, picture.y), core_box(cloud));
    }
  }
}

TEST(Framing, near_plane_is_small_in_small_scenes_and_the_reference_s_in_large_ones) {
  EXPECT_LT(frame_cloud(cube(0.1f, {}), world_up(""), 640, 480).near_depth, 0.003);
  EXPECT_EQ(frame_cloud(cube(1000, {}), world_up(""), 640, 480).near_depth, 0.2);
}

TEST(Framing, distance_and_height_follow_from_the_box) {
  const SceneBox box{{0, 0, 0}, {2, 4, 4}};  // its diagonal is 6
  const glm::dvec3 up(0, -1, 0), center(1, 2, 2);
  const Camera wide = frame_box(box, 1, up, 800, 400);
  const glm::dvec3 eye = wide.position() - center;
  EXPECT_NEAR(glm::length(eye), 1.15 * 3 / std::sin(glm::radians(30.0)), 1e-9);
  EXPECT_NEAR(glm::dot(eye, up), glm::length(eye) * std::sin(glm::radians(15.0)), 1e-9);
  EXPECT_NEAR(wide.focal_px.y, 200 / std::tan(glm::radians(30.0)), 1e-9);
  EXPECT_NEAR(wide.near_depth, 0.01 * 2 * 1.15 * 3, 1e-9);
  const Camera tall = frame_box(box, 1, up, 400, 800);
  const double half_width = std::atan(0.5 * std::tan(glm::radians(30.0)));
  EXPECT_NEAR(glm::length(tall.position() - center), 1.15 * 3 / std::sin(half_width), 1e-9);
  EXPECT_NEAR(glm::length(frame_box(box, 10, up, 800, 400).position() - center), 23, 1e-9);
  GaussianCloud cloud = cube(1, {}, 3);
  cloud.log_scales = {{-9, -1, -9}, {-2, -9, -9}, {-9, -9, -3}};
  EXPECT_NEAR(smallest_framing(cloud), 3 * std::exp(-2.0f), 1e-6);
}

TEST(Framing, ignores_one_far_outlier) {
  GaussianCloud cloud = cube(1, {});
  const Camera without = frame_cloud(cloud, world_up(""), 640, 480);
  cloud.positions[17] = {1e6f, -1e6f, 1e6f};
  const Camera with = frame_cloud(cloud, world_up(""), 640, 480);
  EXPECT_LT(glm::distance(with.position(), without.position()), 0.05);
}

TEST(Framing, is_upright_for_every_vertical_axis) {
  const std::pair<const char*, glm::dvec3> cases[] = {
      {"", {0, -1, 0}}, {"nonsense", {0, -1, 0}}, {"y", {0, 1, 0}},   {"-Y", {0, -1, 0}},
      {"z", {0, 0, 1}}, {"+z", {0, 0, 1}},        {"-z", {0, 0, -1}}, {"X", {1, 0, 0}}};
  const GaussianCloud cloud = cube(2, {1, 2, 3});
  for (const auto& [axis, up] : cases) {
    const Camera camera = frame_cloud(cloud, world_up(axis), 640, 480);
    const glm::dvec3 center(1, 2, 3);
    EXPECT_LT(project(camera, center + 0.5 * up).y, project(camera, center - 0.5 * up).y) << axis;
    EXPECT_NEAR(project(camera, center + 0.5 * up).x, camera.center_px.x, 30) << axis;
    EXPECT_GT(glm::dot(camera.position() - center, up), 0) << axis << ": looks from above";
  }
}

TEST(Framing, one_gaussian_fills_a_part_of_the_picture) {
  GaussianCloud cloud = cube(0, {5, 5, 5}, 1);
  cloud.log_scales[0] = glm::vec3(std::log(0.01f));
  const Camera camera = frame_cloud(cloud, world_up(""), 640, 480);
  const double distance = glm::distance(camera.position(), glm::dvec3(5));
  EXPECT_GT(distance, 0.03);
  EXPECT_LT(distance, 0.1);
  cloud.log_scales[0] = glm::vec3(-INFINITY);  // flat
  EXPECT_TRUE(std::isfinite(frame_cloud(cloud, world_up(""), 640, 480).position().x));
  EXPECT_TRUE(std::isfinite(frame_cloud(GaussianCloud{}, world_up(""), 640, 480).position().x));
}

}  // namespace
}  // namespace qs
