// SPDX-License-Identifier: MIT
//
// Moving the camera by plain functions.
#include "app/framing/camera_control.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

#include "app/framing/scene_box.h"

namespace qs {
namespace {

const glm::dvec3 kUp(0, -1, 0);

Camera some_camera() {
  return look_at({1, -0.5, -3}, {0, 0, 0}, kUp, glm::radians(60.0), 640, 480);
}

void expect_near(glm::dvec3 a, glm::dvec3 b, double tolerance = 1e-9) {
  EXPECT_LT(glm::distance(a, b), tolerance) << a.x << " " << a.y << " " << a.z;
}

TEST(CameraControl, orbiting_keeps_the_distance_and_the_pivot_in_the_middle) {
  const glm::dvec3 pivot(0);
  Camera camera = some_camera();
  const double distance = glm::distance(camera.position(), pivot);
  for (int i = 0; i < 1000; ++i)
    camera = orbited(camera, pivot, kUp, 0.05, i % 7 == 0 ? 0.02 : -0.01);
  EXPECT_NEAR(glm::distance(camera.position(), pivot), distance, 1e-9);
  const glm::dvec3 seen = camera.view_from_world * glm::dvec4(pivot, 1);
  expect_near(seen, {0, 0, distance}, 1e-6);
  const glm::dmat3 rotation(camera.view_from_world);
  EXPECT_NEAR(glm::determinant(rotation), 1, 1e-12);
}

TEST(CameraControl, orbiting_follows_the_cursor) {
  const Camera camera = look_at({0, 0, -3}, {0, 0, 0}, kUp, 1, 100, 100);
  // The near side of the scene moves right and down with the cursor.
  const glm::dvec3 near_side(0, 0, -0.5);
  const Camera yawed = orbited(camera, {}, kUp, 0.1, 0), pitched = orbited(camera, {}, kUp, 0, 0.1);
  EXPECT_GT((yawed.view_from_world * glm::dvec4(near_side, 1)).x, 0.01);
  EXPECT_GT((pitched.view_from_world * glm::dvec4(near_side, 1)).y, 0.01);
  EXPECT_LT(pitched.position().y, -0.1);  // lifted: up is -y
}

TEST(CameraControl, moves_by_exact_angles_and_steps) {
  const double s = std::sin(0.1), c = std::cos(0.1);
  const Camera camera = look_at({0, 0, -3}, {0, 0, 0}, kUp, 1, 100, 100);
  expect_near(orbited(camera, {}, kUp, 0.1, 0).position(), {-3 * s, 0, -3 * c});
  expect_near(orbited(camera, {}, kUp, 0, 0.1).position(), {0, -3 * s, -3 * c});
  expect_near(view_axes(turned(camera, kUp, 0.1, 0)).forward, {s, 0, c});
  expect_near(view_axes(turned(camera, kUp, 0, 0.1)).forward, {0, -s, c});
  expect_near(view_axes(rolled(camera, 0.1)).right, {c, s, 0});  // clockwise: down is +y
  expect_near(moved_to(camera, {1, 2, 3}).position(), {1, 2, 3});
  const Camera other = some_camera();
  const ViewAxes axes = view_axes(other);
  expect_near(stepped(other, {1, 2, 3}).position(),
              other.position() + axes.right + 2.0 * axes.down + 3.0 * axes.forward);
  expect_near(point_at(camera, camera.center_px, 2), {0, 0, -1});
  EXPECT_NEAR(depth_of(camera, {5, 5, -1}), 2, 1e-12);
}

TEST(CameraControl, a_pitch_may_come_within_two_degrees_of_a_pole) {
  const Camera camera = look_at({0, 0, 0}, {0, 0, 1}, kUp, 1, 100, 100);
  const auto height = [&](double degrees) {
    return -view_axes(turned(camera, kUp, 0, glm::radians(degrees))).forward.y;
  };
  EXPECT_NEAR(height(87.5), std::sin(glm::radians(87.5)), 1e-9);
  EXPECT_NEAR(height(88.5), 0, 1e-9);
  EXPECT_NEAR(height(-87.5), -std::sin(glm::radians(87.5)), 1e-9);
  EXPECT_NEAR(height(-88.5), 0, 1e-9);
}

TEST(CameraControl, no_pitch_crosses_a_pole) {
  for (const double step : {0.3, -0.3, 2.0, -2.0}) {
    Camera camera = some_camera();
    for (int i = 0; i < 50; ++i) {
      camera = orbited(camera, {}, kUp, 0.1, step);
      EXPECT_GT(glm::dot(view_axes(camera).down, -kUp), 0) << step;  // never upside down
    }
  }
}

TEST(CameraControl, yaw_works_at_a_pole) {
  const Camera camera = look_at({0.001, -3, 0}, {0, 0, 0}, kUp, 1, 100, 100);
  const Camera turned_camera = turned(camera, kUp, 0.5, 0);
  EXPECT_NEAR(glm::dot(view_axes(camera).right, view_axes(turned_camera).right), std::cos(0.5),
              1e-3);
}

TEST(CameraControl, turning_looks_right_and_up) {
  const Camera camera = look_at({0, 0, 0}, {0, 0, 1}, kUp, 1, 100, 100);
  EXPECT_GT(view_axes(turned(camera, kUp, 0.1, 0)).forward.x, 0);
  EXPECT_LT(view_axes(turned(camera, kUp, 0, 0.1)).forward.y, 0);
  expect_near(turned(camera, kUp, 0.1, 0.1).position(), camera.position());
}

TEST(CameraControl, panning_keeps_what_is_under_the_cursor) {
  const Camera camera = some_camera();
  const glm::dvec2 from(100, 200), by(37, -12);
  const glm::dvec3 point = point_at(camera, from, 2.5);
  EXPECT_NEAR(depth_of(camera, point), 2.5, 1e-12);
  const Camera panned = stepped(camera, pan_step(camera, 2.5, by));
  expect_near(point_at(panned, from + by, 2.5), point);
}

TEST(CameraControl, the_field_of_view_is_what_was_asked_for_within_limits) {
  const Camera camera = some_camera();
  EXPECT_NEAR(vertical_fov(camera), glm::radians(60.0), 1e-12);
  EXPECT_NEAR(vertical_fov(with_vertical_fov(camera, 1)), 1, 1e-12);
  EXPECT_NEAR(vertical_fov(with_vertical_fov(camera, 100)), glm::radians(170.0), 1e-9);
  EXPECT_NEAR(vertical_fov(with_vertical_fov(camera, 0)), glm::radians(0.5), 1e-9);
}

TEST(CameraControl, rolling_turns_the_picture_and_nothing_else) {
  const Camera camera = some_camera(), tilted = rolled(camera, 0.3);
  expect_near(tilted.position(), camera.position());
  expect_near(view_axes(tilted).forward, view_axes(camera).forward);
  EXPECT_NEAR(glm::dot(view_axes(tilted).right, view_axes(camera).right), std::cos(0.3), 1e-12);
}

TEST(CameraControl, framing_shows_scenes_of_every_size_whole) {
  for (const float extent : {0.1f, 1.0f, 1000.0f}) {
    const SceneBox box{glm::vec3(-0.5f * extent), glm::vec3(0.5f * extent)};
    for (const glm::dvec3 up : {kUp, glm::dvec3(0, 0, 1)}) {
      const Camera camera = frame_box(box, 1e-3f, up, 1280, 720);
      EXPECT_LT(camera.near_depth, 0.02 * static_cast<double>(extent));
      EXPECT_GT(glm::dot(view_axes(camera).down, -up), 0.5);  // upright
      for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at((corner & 1 ? 0.5 : -0.5) * extent, (corner & 2 ? 0.5 : -0.5) * extent,
                            (corner & 4 ? 0.5 : -0.5) * extent);
        const glm::dvec3 view = camera.view_from_world * glm::dvec4(at, 1);
        ASSERT_GT(view.z, camera.near_depth);
        const glm::dvec2 pixel = glm::dvec2(view) / view.z * camera.focal_px + camera.center_px;
        EXPECT_TRUE(pixel.x > 0 && pixel.x < 1280 && pixel.y > 0 && pixel.y < 720);
      }
    }
  }
}

}  // namespace
}  // namespace qs
