// SPDX-License-Identifier: MIT
#include "raster/pages/surfaces.h"

#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

#include "raster/pages/cut.h"
#include "support/scenes.h"

namespace qs {
namespace {

// A wall at depth 5 fills the left half of the picture.
LodSurfaces wall(const Camera& camera, float margin = 0) {
  std::vector<float> depths(static_cast<std::size_t>(camera.width * camera.height));
  for (int i = 0; i < camera.width * camera.height; ++i)
    if (i % camera.width < camera.width / 2) depths[static_cast<std::size_t>(i)] = 5;
  return {camera, depths, margin};
}

// The point of a pixel at a depth.
glm::vec3 at(const Camera& camera, double x, double y, double depth) {
  return {(x - camera.center_px.x) / camera.focal_px.x * depth,
          (y - camera.center_px.y) / camera.focal_px.y * depth, depth};
}

TEST(Surfaces, hide_the_balls_behind_them) {
  const Camera camera = test::front_camera(80, 60);
  const LodSurfaces surfaces = wall(camera);
  EXPECT_EQ(surfaces.share_seen(at(camera, 20, 30, 4), 0.1f), 1) << "in front";
  EXPECT_EQ(surfaces.share_seen(at(camera, 20, 30, 5.05), 0.1f), 1) << "it reaches the wall";
  EXPECT_EQ(surfaces.share_seen(at(camera, 20, 30, 6), 0.1f), LodSurfaces::kLeastSeen) << "behind";
  EXPECT_EQ(surfaces.share_seen(at(camera, 60, 30, 6), 0.1f), 1) << "beside the wall";
  EXPECT_NEAR(surfaces.share_seen(at(camera, 40, 30, 8), 1), 0.5, 0.13) << "half behind it";
}

TEST(Surfaces, say_nothing_about_balls_that_the_picture_does_not_show) {
  const Camera camera = test::front_camera(80, 60);
  const LodSurfaces surfaces = wall(camera);
  EXPECT_EQ(surfaces.share_seen(at(camera, -60, 30, 6), 0.1f), 1) << "left of the picture";
  EXPECT_EQ(surfaces.share_seen({0, 0, -3}, 1), 1) << "behind the camera";
  EXPECT_EQ(surfaces.share_seen({0, 0, 6}, 7), 1) << "around the camera";
}

TEST(Surfaces, count_pixels_around_a_ball) {
  const Camera camera = test::front_camera(80, 60);
  const glm::vec3 center = at(camera, 35, 30, 6);  // 5 pixels from the wall's edge
  EXPECT_EQ(wall(camera).share_seen(center, 0.01f), LodSurfaces::kLeastSeen);
  EXPECT_NEAR(wall(camera, 10).share_seen(center, 0.01f), 0.25, 0.13);
}

TEST(Surfaces, lower_the_gains_of_a_view) {
  const Camera camera = test::front_camera(80, 60);
  for (const float outside : {1e-4f, 1 / 16.0f}) {
    LodView view(camera, outside);
    view.surfaces = std::make_shared<const LodSurfaces>(wall(camera));
    EXPECT_EQ(view(at(camera, 20, 30, 6), 0.1f).share, std::max(outside, LodSurfaces::kLeastSeen));
    EXPECT_EQ(view(at(camera, 20, 30, 4), 0.1f).share, 1);
    EXPECT_EQ(view(at(camera, -60, 30, 6), 0.1f).share, outside);
  }
}

}  // namespace
}  // namespace qs
