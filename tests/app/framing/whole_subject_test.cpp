// SPDX-License-Identifier: MIT
//
// The framing of turntables: the whole subject in every picture, and no eye in fog.
#include "app/framing/whole_subject.h"

#include <cmath>
#include <limits>

#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

#include "app/film/film.h"
#include "app/framing/camera_control.h"
#include "app/framing/first_view.h"
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "support/paths.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace qs {
namespace {

// The largest share of the picture's width or height, from its centre, at which a corner of the box
// is; infinite behind the eye.
double farthest_corner(const Camera& camera, const SceneBox& box) {
  double share = 0;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner(i & 1 ? box.high.x : box.low.x, i & 2 ? box.high.y : box.low.y,
                            i & 4 ? box.high.z : box.low.z);
    const glm::dvec3 at = camera.view_from_world * glm::dvec4(corner, 1);
    if (at.z <= 0) return std::numeric_limits<double>::infinity();
    const glm::dvec2 pixel = camera.focal_px * glm::dvec2(at) / at.z;
    share = std::max(
        {share, 2 * std::abs(pixel.x) / camera.width, 2 * std::abs(pixel.y) / camera.height});
  }
  return share;
}

Framing framing_before(double distance) {
  Framing framing;
  framing.eye = {0, 0, -distance};
  return framing;
}

TEST(WholeSubject, stays_in_the_middle_of_pictures_of_every_shape_from_every_angle) {
  const SceneBox box{glm::vec3(-0.3f, -1, -0.4f), glm::vec3(0.6f, 1.2f, 0.4f)};
  for (const double distance : {1.2, 2.0, 4.0, 30.0}) {
    for (const glm::ivec2 size : {glm::ivec2(1280, 720), {720, 1280}, {100, 100}, {2000, 100}}) {
      const CameraTrack track = turntable(framing_before(distance), arc_of(360), Ease::none, box);
      for (int i = 0; i < 40; ++i)
        EXPECT_LE(farthest_corner(camera_of(track, i, 40, size), box), kWholeShare + 1e-3)
            << distance << " " << size.x << " " << i;
    }
  }
}

TEST(WholeSubject, widens_the_view_before_it_leaves_the_distance_of_the_photographs) {
  const SceneBox box{glm::vec3(-1), glm::vec3(1)};
  const Framing far = whole_subject(framing_before(30), box, arc_of(90), 1.5);
  EXPECT_EQ(far.vertical_fov, Framing().vertical_fov);
  const Framing near = whole_subject(framing_before(3), box, arc_of(90), 1.5);
  EXPECT_GT(near.vertical_fov, Framing().vertical_fov);
  EXPECT_NEAR(glm::distance(near.eye, near.target), 3, 1e-9);
  const Framing inside = whole_subject(framing_before(0.5), box, arc_of(90), 1.5);
  EXPECT_EQ(inside.eye, framing_before(0.5).eye) << "a room is filmed from inside";
}

TEST(WholeSubject, an_arc_ends_before_fog) {
  GaussianCloud cloud = test::single_gaussian({0, 0, 0}, 0.1f, {1, 1, 1}, 0.9f);
  const Framing framing = framing_before(4);
  EXPECT_TRUE(clear_arc(arc_of(360), framing, cloud).whole());
  const Camera camera = look_at(framing.eye, framing.target, framing.up, 1, 16, 16);
  const double angle = glm::radians(50.0);
  const glm::vec3 at(orbited(camera, framing.target, framing.up, angle, 0).position());
  test::append(cloud, test::single_gaussian(at, 0.3f, {1, 1, 1}, 0.9f));
  EXPECT_TRUE(is_in_fog(cloud, at));
  EXPECT_FALSE(is_in_fog(cloud, framing.eye));
  const Arc arc = clear_arc(arc_of(180), framing, cloud);
  EXPECT_NEAR(arc.low, -0.5 * glm::pi<double>(), 1e-9);
  EXPECT_LT(arc.high, angle - glm::radians(5.0));
  EXPECT_GT(arc.high, angle - glm::radians(20.0));
  EXPECT_EQ(clear_arc({-0.1, 0.1}, framing_before(0.05), cloud).high, 0.1) << "begins in fog";
}

// Films the scene's turntable and looks at 60 of its cameras.
void expect_a_good_turntable(const Scene& scene, const std::vector<Camera>& cameras) {
  ThreadPool& pool = test::pool();
  const Framing framing = subject_framing(
      cameras, std::nullopt, [&] { return choose_framing(scene.cloud, std::nullopt, pool); });
  const SceneBox box = subject_box(scene.cloud);
  for (const glm::ivec2 size : {glm::ivec2(1280, 720), {400, 640}}) {
    const CameraTrack track =
        turntable_of(scene.cloud, cameras, framing, {std::nullopt, Ease::none, size}, pool);
    for (int i = 0; i < 60; ++i) {
      const Camera camera = camera_of(track, i, 60, size);
      EXPECT_LE(farthest_corner(camera, box), kWholeShare + 1e-3) << size.x << " " << i;
      EXPECT_FALSE(is_in_fog(scene.cloud, camera.position())) << size.x << " " << i;
    }
  }
}

TEST(Turntable, of_the_bundled_scene_shows_its_whole_subject_outside_of_fog) {
  const std::filesystem::path assets = test::source_path("assets");
  expect_a_good_turntable(read_scene(assets / "plush.ply", test::pool()),
                          read_cameras(assets / "cameras.json"));
}

TEST(Turntable, of_scenes_without_cameras_shows_their_whole_subject_outside_of_fog) {
  for (const char* name : {"scenes/plush.spz", "scenes/wild/playcanvas_guitar.compressed.ply",
                           "scenes/wild/playbot_streamed"}) {
    QS_NEEDS_SHARED(name);
    SCOPED_TRACE(name);
    expect_a_good_turntable(read_scene(test::shared_path(name), test::pool()), {});
  }
}

}  // namespace
}  // namespace qs
