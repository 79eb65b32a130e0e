// SPDX-License-Identifier: MIT
// Faces, which are sorted by distance, and orthographic views.
#include <cmath>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "raster/api/renderer.h"
#include "raster/scene/image_metrics.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

constexpr const char* kModes[] = {"reference", "3dgs", "quadbox", "exact"};

Frame drawn(const GaussianCloud& cloud, const Camera& camera, const char* mode = "quadbox",
            Pipeline pipeline = Pipeline::fast) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(cloud, {});
  RenderSettings settings;
  settings.mode = find_culler(mode);
  settings.pipeline = pipeline;
  Outputs outputs;
  outputs.depth = true;
  return renderer->render(camera, settings, outputs);
}

Camera face(int width = 65, int height = 65) {
  return test::with_projection(test::front_camera(width, height), Projection::face);
}

glm::vec3 color_at(const Frame& frame, int x, int y) {
  return {frame.color.at(x, y, 0), frame.color.at(x, y, 1), frame.color.at(x, y, 2)};
}

TEST(Face, shows_in_front_what_is_nearer_to_the_eye) {
  // At the picture's edge the red one has the smaller z and the larger distance.
  const double slope = 0.5;
  const auto at = [&](double z, double sideways) { return glm::vec3(slope * z + sideways, 0, z); };
  GaussianCloud cloud = test::single_gaussian(at(4, 0), 0.4f, {1, 0, 0}, 9);
  test::append(cloud, test::single_gaussian({1.6, 0, 4.05}, 0.4f, {0, 1, 0}, 9));
  ASSERT_LT(glm::length(cloud.positions[1]), glm::length(cloud.positions[0]));
  const Camera pinhole = test::front_camera(65, 65);
  const int x = static_cast<int>(std::lround(pinhole.center_px.x + 0.45 * pinhole.focal_px.x));
  for (const char* mode : kModes) {
    for (const Pipeline pipeline : {Pipeline::fast, Pipeline::classic}) {
      SCOPED_TRACE(mode);
      const glm::vec3 by_z = color_at(drawn(cloud, pinhole, mode, pipeline), x, 32);
      const glm::vec3 by_distance = color_at(drawn(cloud, face(), mode, pipeline), x, 32);
      EXPECT_GT(by_z.x, 2 * by_z.y);
      EXPECT_GT(by_distance.y, 2 * by_distance.x);
    }
  }
}

TEST(Face, measures_depth_and_the_near_limit_by_distance) {
  struct Case {
    glm::vec3 position;
    bool in_face, in_pinhole;
  };
  const Case cases[] = {{{0, 0, 3}, true, true},        {{0, 0, 0.15}, false, false},
                        {{0.09, 0, 0.19}, true, false}, {{0.09, 0, -0.19}, false, false},
                        {{0, 0, -3}, false, false},     {{0.05, 0.07, 0.19}, true, false},
                        {{0.01, 0, 0.201}, true, true}};
  for (const Case& each : cases) {
    SCOPED_TRACE(testing::Message() << each.position.x << " " << each.position.z);
    const GaussianCloud cloud = test::single_gaussian(each.position, 0.01f, {1, 1, 1}, 9);
    for (const char* mode : kModes) {
      const Frame in_face = drawn(cloud, face(), mode);
      EXPECT_EQ(in_face.stats.visible, each.in_face ? 1u : 0u) << mode;
      EXPECT_EQ(drawn(cloud, test::front_camera(65, 65), mode).stats.visible,
                each.in_pinhole ? 1u : 0u)
          << mode;
      float depth = 0;
      for (const float value : in_face.depth.median) depth = std::max(depth, value);
      EXPECT_NEAR(depth, each.in_face ? glm::length(each.position) : 0, 1e-5) << mode;
    }
  }
}

TEST(Face, cut_to_a_part_is_that_part_of_the_whole) {
  GaussianCloud cloud = test::random_cloud(2000, 1, 5);
  const Frame whole = drawn(cloud, face(160, 160), "exact");
  for (const glm::ivec2 corner : {glm::ivec2(0, 0), {90, 0}, {17, 80}, {100, 120}}) {
    Camera part = face(160, 160);
    part.width = 60;
    part.height = 40;
    part.center_px -= corner;
    part.face_edge = 80 / part.focal_px.x;
    const Frame cut = drawn(cloud, part, "exact");
    // Means are rounded elsewhere, so single contributions pass the least alpha, 1/255, or not.
    std::size_t different = 0;
    for (int y = 0; y < part.height; ++y)
      for (int x = 0; x < part.width; ++x)
        for (int c = 0; c < 3; ++c)
          different += std::abs(cut.color.at(x, y, c) -
                                whole.color.at(corner.x + x, corner.y + y, c)) > 4e-3f;
    EXPECT_EQ(different, 0u) << corner.x << "," << corner.y;
  }
}

TEST(Orthographic, is_a_pinhole_camera_at_ten_thousand_times_the_distance) {
  GaussianCloud cloud = test::random_cloud(50, 3, 9);
  // Depths that differ in single precision at the far camera, too.
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.positions[i].z = 4 + static_cast<float>(i);
  constexpr double kFar = 1e4 * 500;
  Camera parallel = test::with_projection(test::front_camera(120, 90), Projection::orthographic);
  Camera pinhole = test::front_camera(120, 90);
  pinhole.focal_px = parallel.focal_px * kFar;
  pinhole.view_from_world[3].z = kFar;
  const Frame a = drawn(cloud, parallel, "reference"), b = drawn(cloud, pinhole, "reference");
  float largest = 0, brightest = 0;
  for (std::size_t i = 0; i < a.color.values.size(); ++i) {
    largest = std::max(largest, std::abs(a.color.values[i] - b.color.values[i]));
    brightest = std::max(brightest, a.color.values[i]);
  }
  EXPECT_LT(largest, 1e-3f);
  EXPECT_GT(brightest, 0.5f);
  EXPECT_GT(psnr(a.color, b.color, test::pool()), 80);
  for (const char* mode : {"3dgs", "quadbox", "exact"}) {
    EXPECT_GT(psnr(drawn(cloud, parallel, mode).color, a.color, test::pool()), 60) << mode;
    EXPECT_GT(psnr(drawn(cloud, parallel, mode, Pipeline::classic).color, a.color, test::pool()),
              60)
        << mode;
  }
}

TEST(Orthographic, shows_a_gaussian_of_one_size_at_every_depth) {
  Camera camera = test::with_projection(test::front_camera(64, 64), Projection::orthographic);
  camera.focal_px = glm::dvec2(10);  // px per unit
  for (const float z : {0.3f, 1.0f, 50.0f, 1e5f}) {
    const GaussianCloud cloud = test::single_gaussian({1, -0.5f, z}, 0.5f, {1, 1, 1}, 9);
    const Frame frame = drawn(cloud, camera);
    // 31.5 + 10 x 1 across and 31.5 - 10 x 0.5 down; 10 x 0.5 px are a standard deviation.
    const float middle = frame.color.at(41, 26, 0);
    EXPECT_NEAR(frame.color.at(46, 26, 0) / middle,
                std::exp(-0.5 * 4.5 * 4.5 / 25.3) / std::exp(-0.5 * 0.25 / 25.3), 0.01)
        << z;
    EXPECT_EQ(frame.stats.visible, 1u);
  }
  EXPECT_EQ(drawn(test::single_gaussian({0, 0, 0.1f}, 0.5f, {1, 1, 1}, 9), camera).stats.visible,
            0u);
}

}  // namespace
}  // namespace qs
