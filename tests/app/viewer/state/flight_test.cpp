// SPDX-License-Identifier: MIT
//
// Motion that takes time.
#include <cmath>
#include <filesystem>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "app/framing/camera_control.h"
#include "app/framing/depth_ahead.h"
#include "app/support/driven_viewer.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/hud_text.h"
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace qs {
namespace {

using test::DrivenScene;

// A wall of opaque Gaussians across the view of front_camera(), at a depth.
void add_wall(GaussianCloud& cloud, float depth, float opacity_logit = 5) {
  for (int x = -20; x <= 20; ++x) {
    for (int y = -20; y <= 20; ++y) {
      const float step = 0.1f * depth;
      test::append(cloud, test::single_gaussian(
                              {step * static_cast<float>(x), step * static_cast<float>(y), depth},
                              step, {0.5f, 0.5f, 0.5f}, opacity_logit));
    }
  }
}

TEST(DepthAhead, is_that_of_what_hides_the_rest) {
  const Camera camera = test::front_camera(320, 240);
  GaussianCloud cloud;
  add_wall(cloud, 30);
  EXPECT_NEAR(depth_ahead(camera, landmarks_of(cloud)).value(), 30, 1e-4);
  GaussianCloud hidden;
  add_wall(hidden, 3);
  add_wall(hidden, 30);
  EXPECT_NEAR(depth_ahead(camera, landmarks_of(hidden)).value(), 3, 1e-4);
  GaussianCloud seen_through;
  add_wall(seen_through, 3, -6);  // opacity 0.0025
  add_wall(seen_through, 30);
  EXPECT_NEAR(depth_ahead(camera, landmarks_of(seen_through)).value(), 30, 1e-4);
}

TEST(DepthAhead, hardly_depends_on_the_size_of_the_sample) {
  const std::filesystem::path assets = test::source_path("assets");
  const Scene scene = read_scene(assets / "plush.ply", test::pool(), {});
  const std::vector<Camera> cameras = read_cameras(assets / "cameras.json");
  const std::vector<Landmark> all = landmarks_of(scene.cloud, scene.cloud.size());
  const std::vector<Landmark> some = landmarks_of(scene.cloud);
  EXPECT_LT(5 * some.size(), all.size());
  for (std::size_t i = 0; i < cameras.size(); i += 12) {
    const double depth = depth_ahead(cameras[i], all).value();
    EXPECT_NEAR(depth_ahead(cameras[i], some).value(), depth, 0.15 * depth) << i;
  }
}

TEST(DepthAhead, is_unset_where_nothing_is) {
  Camera camera = test::front_camera(320, 240);
  EXPECT_FALSE(depth_ahead(camera, {}));
  GaussianCloud cloud;
  add_wall(cloud, 5);
  EXPECT_FALSE(depth_ahead(turned(camera, {0, -1, 0}, 3.1, 0), landmarks_of(cloud)));
  GaussianCloud flat;
  test::append(flat, test::single_gaussian({0, 0, 5}, 1, {1, 1, 1}, 5));
  flat.log_scales[0].y = -INFINITY;
  EXPECT_EQ(depth_ahead(camera, landmarks_of(flat)), 5);
  GaussianCloud broken;
  test::append(broken, test::single_gaussian({0, 0, 5}, 1, {1, 1, 1}, 5));
  broken.positions[0].x = NAN;
  EXPECT_TRUE(landmarks_of(broken).empty());
}

// A view of a wall that is `distance` away.
struct FlightTest : testing::Test {
  DrivenScene driven{0};
  const Viewer& viewer = driven.viewer;

  void face_wall(float distance) {
    GaussianCloud cloud;
    add_wall(cloud, distance);
    driven.apply([&](Viewer& v) {
      v.scene->landmarks = landmarks_of(cloud);
      v.camera = test::front_camera(640, 480);
    });
  }
  // Flies as the loop does; returns the distance. `pictures`: of the camera's way are shown.
  double fly_for(double seconds, glm::dvec3 direction, double factor = 1, bool pictures = true) {
    const glm::dvec3 from = viewer.camera.position();
    constexpr double kTurn = 1.0 / 64;
    for (double t = 0; t < seconds; t += kTurn) {
      if (pictures) driven.apply([](Viewer& v) { ++v.frames; });
      if (direction != glm::dvec3(0)) driven.apply(action::fly, direction, factor);
      driven.apply(action::tick, Turn{viewer.now + kTurn}, kTurn);
    }
    return glm::distance(viewer.camera.position(), from);
  }
};

TEST_F(FlightTest, its_speed_follows_the_distance_ahead_not_the_scene_s_extent) {
  for (const float distance : {1.0f, 40.0f, 1000.0f}) {
    face_wall(distance);
    EXPECT_NEAR(flying_speed(viewer), 0.5 * static_cast<double>(distance),
                1e-4 * static_cast<double>(distance));
    // When flying down the distance stays the same. At full speed a second covers half of the
    // distance.
    fly_for(1, {0, 0.001, 0});
    const double speed = glm::length(viewer.flight.velocity) / 0.001;
    EXPECT_NEAR(speed, 0.5 * static_cast<double>(distance), 0.01 * static_cast<double>(distance));
    fly_for(3, {});
  }
}

TEST_F(FlightTest, accelerates_and_slows_down_to_a_stop) {
  face_wall(10);
  const double first = fly_for(1.0 / 64, {0, 1, 0}), begin = fly_for(0.1, {0, 1, 0});
  EXPECT_LT(first, 0.2 * 5 / 64);
  EXPECT_LT(begin, 0.8 * 0.1 * 5);
  fly_for(1, {0, 1, 0});
  const double after = fly_for(0.1, {});
  EXPECT_GT(after, 0.2 * 0.1 * 5);
  EXPECT_LT(after, 0.9 * 0.1 * 5);
  fly_for(2, {});
  EXPECT_EQ(viewer.flight.velocity, glm::dvec3(0));
  EXPECT_EQ(fly_for(1, {}), 0);
  EXPECT_TRUE(viewer.still());
}

TEST_F(FlightTest, is_half_as_fast_sideways) {
  face_wall(10);
  const double down = fly_for(1, {0, 1, 0});
  fly_for(2, {});
  EXPECT_NEAR(fly_for(1, {1, 0, 0}), 0.5 * down, 0.02 * down);
}

TEST_F(FlightTest, covers_at_most_half_of_the_distance_ahead_until_the_next_picture) {
  face_wall(10);
  EXPECT_NEAR(fly_for(4, {0, 0, 1}, 5, false), 5, 1e-4) << "no picture was shown meanwhile";
  driven.apply([](Viewer& v) { ++v.frames; });
  EXPECT_NEAR(fly_for(4, {0, 0, 1}, 5, false), 2.5, 0.05);
}

TEST_F(FlightTest, the_wheel_changes_the_speed_in_fly_mode_and_the_distance_in_orbit_mode) {
  face_wall(10);
  driven.apply(action::turn_wheel, 1.0);
  EXPECT_EQ(viewer.flight.factor, 1);
  const glm::dvec3 before = viewer.camera.position();
  driven.press("V");
  driven.apply(action::turn_wheel, 3.0);
  EXPECT_DOUBLE_EQ(viewer.flight.factor, 1.2 * 1.2 * 1.2);
  EXPECT_EQ(viewer.camera.position(), before);
  EXPECT_EQ(status_line(viewer).note,
            fmt::format("flying {:.3g} units a second", flying_speed(viewer)));
  driven.apply(action::turn_wheel, -1000.0);
  EXPECT_DOUBLE_EQ(viewer.flight.factor, 0.01);
}

TEST_F(FlightTest, stays_level_and_does_not_turn_over_at_the_pole) {
  face_wall(10);
  for (int i = 0; i < 200; ++i) driven.apply(action::look, glm::dvec2(3, 9));
  for (int i = 0; i < 300; ++i) driven.apply(action::orbit, glm::dvec2(5, -40));
  fly_for(0.5, {1, 1, 1});
  const ViewAxes axes = view_axes(viewer.camera);
  EXPECT_NEAR(glm::dot(axes.right, viewer.scene->up), 0, 1e-9) << "level";
  EXPECT_LT(glm::dot(axes.down, viewer.scene->up), 0) << "not upside down";
}

TEST_F(FlightTest, a_view_is_reached_within_a_moment_and_at_once_in_scripts) {
  DrivenScene scene(3);
  const auto target = [&](int i) {
    return scene.viewer.scene->cameras[static_cast<std::size_t>(i)].position();
  };
  scene.press("]");
  EXPECT_EQ(scene.viewer.dataset_camera, 1);
  scene.apply([](Viewer& v) { v.animates_moves = true; });
  const glm::dvec3 from = scene.viewer.camera.position();
  scene.press("]");
  EXPECT_EQ(scene.viewer.camera.position(), from);
  EXPECT_TRUE(scene.viewer.moving());
  double way = 0;
  for (int turn = 0; turn < 20; ++turn) {
    scene.apply(action::tick, Turn{scene.viewer.now + 0.02}, 0.02);
    const double done = glm::distance(scene.viewer.camera.position(), from);
    EXPECT_GE(done, way - 1e-9);
    way = done;
    if (turn == 5) {
      EXPECT_GT(done, 0);
      EXPECT_GT(glm::distance(scene.viewer.camera.position(), target(2)), 0.1);
      EXPECT_EQ(scene.viewer.dataset_camera, -1);
    }
  }
  EXPECT_LT(glm::distance(scene.viewer.camera.position(), target(2)), 1e-9);
  EXPECT_EQ(scene.viewer.dataset_camera, 2);
  EXPECT_FALSE(scene.viewer.travel);
  scene.press("]");
  scene.press("]");  // counts from the target of the first travel
  EXPECT_EQ(scene.viewer.travel->dataset_camera, 1);
  scene.apply(action::orbit, glm::dvec2(1, 1));
  EXPECT_FALSE(scene.viewer.travel) << "the user takes over";
}

TEST_F(FlightTest, a_framed_point_comes_into_the_middle_at_half_its_distance) {
  face_wall(10);
  const glm::dvec3 point(2, -1, 8);
  const double distance = glm::distance(viewer.camera.position(), point);
  driven.apply(action::frame_point, point);
  EXPECT_EQ(viewer.pivot, point);
  EXPECT_NEAR(depth_of(viewer.camera, point), 0.5 * distance, 1e-9);
  const glm::dvec3 seen = viewer.camera.view_from_world * glm::dvec4(point, 1);
  EXPECT_NEAR(seen.x, 0, 1e-9);
  EXPECT_NEAR(seen.y, 0, 1e-9);
}

}  // namespace
}  // namespace qs
