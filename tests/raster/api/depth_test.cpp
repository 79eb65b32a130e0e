// SPDX-License-Identifier: MIT
// Alpha and depth of the CPU backend: by hand, against the fp64 reference, and across modes.
#include <cmath>

#include <gtest/gtest.h>

#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "raster/api/renderer.h"
#include "support/depth_maps.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace qs {
namespace {

DepthMaps depth_of(const GaussianCloud& cloud, const Camera& camera, const char* mode,
                   RenderSettings settings = {}, int threads = 2) {
  ThreadPool pool(threads);
  const auto renderer = make_renderer(Backend::cpu, pool);
  renderer->upload(cloud, {});
  settings.mode = find_culler(mode);
  Outputs outputs;
  outputs.color = false;
  outputs.depth = true;
  return renderer->render(camera, settings, outputs).depth;
}

/// A Gaussian on the optical axis that covers the picture.
GaussianCloud layer(float z, double alpha) {
  return test::single_gaussian({0, 0, z}, 5, {1, 1, 1},
                               static_cast<float>(std::log(alpha / (1 - alpha))));
}

constexpr std::size_t kMiddle = 16 * 33 + 16;  // of 33 x 33 pixels; the falloff is 1 there

TEST(Depth, of_two_known_gaussians_has_the_values_of_the_definition) {
  const Camera camera = test::front_camera(33, 33);
  GaussianCloud cloud = layer(4, 0.5);
  test::append(cloud, layer(2, 0.4));
  for (const char* mode : {"reference", "3dgs", "quadbox", "exact"}) {
    SCOPED_TRACE(mode);
    const DepthMaps one = depth_of(layer(2, 0.4), camera, mode);
    EXPECT_NEAR(one.alpha[kMiddle], 0.4f, 1e-6);
    EXPECT_NEAR(one.expected[kMiddle], 2, 1e-6);
    EXPECT_EQ(one.median[kMiddle], 0) << "60 % of the light passes";
    const DepthMaps two = depth_of(cloud, camera, mode);  // weights 0.4 and 0.6 x 0.5
    EXPECT_NEAR(two.alpha[kMiddle], 0.7f, 1e-6);
    EXPECT_NEAR(two.expected[kMiddle], (0.4 * 2 + 0.3 * 4) / 0.7, 2e-6);
    EXPECT_EQ(two.median[kMiddle], 4);
    test::append(cloud, layer(8, 0.9));
    const DepthMaps three = depth_of(cloud, camera, mode);
    EXPECT_NEAR(three.alpha[kMiddle], 0.97f, 1e-6);
    EXPECT_EQ(three.median[kMiddle], 4) << "the first one behind which at most half is left";
    cloud = layer(4, 0.5);
    test::append(cloud, layer(2, 0.4));
  }
}

TEST(Depth, is_zero_where_nothing_is_drawn) {
  const Camera camera = test::front_camera(50, 40);
  for (const char* mode : {"reference", "quadbox"}) {
    const DepthMaps maps =
        depth_of(test::single_gaussian({0, 0, -3}, 1, {1, 1, 1}, 2), camera, mode);
    for (const std::vector<float>* map : {&maps.alpha, &maps.expected, &maps.median})
      EXPECT_EQ(*map, std::vector<float>(50 * 40)) << mode;
  }
}

TEST(Depth, is_that_of_the_reference_within_the_stated_bound) {
  const Camera camera = test::front_camera(161, 117);
  for (const unsigned seed : {11u, 12u, 13u}) {
    const GaussianCloud cloud = test::random_cloud(4000, 0, seed);
    RenderSettings other;
    other.antialiased = true;
    other.splat_scale = 0.7f;
    for (const RenderSettings& settings : {RenderSettings(), other}) {
      const DepthMaps expected = depth_of(cloud, camera, "reference", settings);
      for (const char* mode : {"adr", "quadbox", "exact"}) {
        SCOPED_TRACE(testing::Message() << mode << " " << seed);
        test::expect_same_depth(depth_of(cloud, camera, mode, settings), expected);
      }
    }
  }
}

TEST(Depth, of_the_bundled_scene_is_that_of_the_reference) {
  const GaussianCloud cloud = test::read_scene(test::source_path("assets/plush.ply")).cloud;
  const Camera camera =
      read_cameras(test::source_path("assets/cameras.json")).front().resized(160, 120);
  test::expect_same_depth(depth_of(cloud, camera, "quadbox"), depth_of(cloud, camera, "reference"));
}

TEST(Depth, is_equal_in_all_lossless_modes_pipelines_and_tile_sizes) {
  const GaussianCloud cloud = test::random_cloud(4000, 0, 8);
  const Camera camera = test::front_camera(133, 97);
  const DepthMaps adr = depth_of(cloud, camera, "adr");
  RenderSettings classic, small, large;
  classic.pipeline = Pipeline::classic;
  small.tile_px = 8;
  large.tile_px = 32;
  for (const char* mode : {"quadbox-naive", "quadbox", "exact"}) {
    for (const RenderSettings& settings : {RenderSettings(), classic, small, large})
      EXPECT_TRUE(test::equal(depth_of(cloud, camera, mode, settings), adr)) << mode;
  }
}

TEST(Depth, does_not_depend_on_the_number_of_threads) {
  const GaussianCloud cloud = test::random_cloud(4000, 0, 9);
  const Camera camera = test::front_camera(200, 150);
  for (const char* mode : {"quadbox", "reference"}) {
    const DepthMaps one = depth_of(cloud, camera, mode, {}, 1);
    for (const int threads : {2, 3, 8})
      EXPECT_TRUE(test::equal(depth_of(cloud, camera, mode, {}, threads), one)) << threads;
  }
}

TEST(Depth, is_drawn_only_when_asked_for_and_changes_nothing_else) {
  const GaussianCloud cloud = test::random_cloud(2000, 0, 10);
  const Camera camera = test::front_camera(90, 60);
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(cloud, {});
  Outputs outputs;
  outputs.depth = outputs.used = true;
  const Frame with = renderer->render(camera, {}, outputs);
  EXPECT_TRUE(test::equal(with.depth, depth_of(cloud, camera, "quadbox")));
  outputs.depth = false;
  const Frame without = renderer->render(camera, {}, outputs);
  EXPECT_EQ(with.color.values, without.color.values);
  EXPECT_EQ(with.used, without.used);
  EXPECT_TRUE(without.depth.alpha.empty());
  EXPECT_TRUE(without.depth.expected.empty());
  EXPECT_TRUE(without.depth.median.empty());
}

TEST(Depth, of_a_region_in_mode_reference_is_zero_outside_of_it) {
  const GaussianCloud cloud = test::random_cloud(500, 0, 4);
  const Camera camera = test::front_camera(70, 40);
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(cloud, {});
  RenderSettings settings;
  settings.mode = kReferenceMode;
  Outputs outputs;
  outputs.depth = true;
  const DepthMaps whole = renderer->render(camera, settings, outputs).depth;
  outputs.region = PixelBox{10, 5, 33, 29};
  const DepthMaps part = renderer->render(camera, settings, outputs).depth;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 70; ++x) {
      const bool inside = x >= 10 && x < 33 && y >= 5 && y < 29;
      const auto at = static_cast<std::size_t>(y * 70 + x);
      EXPECT_EQ(part.alpha[at], inside ? whole.alpha[at] : 0);
      EXPECT_EQ(part.expected[at], inside ? whole.expected[at] : 0);
    }
  }
}

}  // namespace
}  // namespace qs
