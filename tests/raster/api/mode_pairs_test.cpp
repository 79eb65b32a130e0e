// SPDX-License-Identifier: MIT
// Outputs::mode_pairs of the CPU backend: every count is the statistic of that mode's own frame.
#include "support/mode_pairs.h"

#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/shared.h"

namespace qs {
namespace {

std::unique_ptr<Renderer> renderer_of(const GaussianCloud& cloud, int threads = 2) {
  auto renderer = make_renderer(Backend::cpu, test::pool(threads));
  renderer->upload(cloud, {});
  return renderer;
}

TEST(ModePairs, are_the_statistics_of_the_own_frame_of_each_mode_in_both_pipelines) {
  for (test::CountedScene& scene : test::counted_scenes(4000)) {
    const auto renderer = renderer_of(scene.cloud);
    for (const Pipeline pipeline : {Pipeline::classic, Pipeline::fast}) {
      SCOPED_TRACE(scene.name + " " + kPipelineNames[static_cast<int>(pipeline)]);
      scene.settings.pipeline = pipeline;
      test::expect_own_statistics(*renderer, *renderer, scene.camera, scene.settings);
    }
  }
}

TEST(ModePairs, of_the_bundled_scene_are_the_statistics_of_its_frames) {
  const GaussianCloud cloud = test::read_scene(test::source_path("assets/plush.ply")).cloud;
  const auto renderer = renderer_of(cloud);
  for (const Camera& camera : read_cameras(test::source_path("assets/cameras.json")))
    test::expect_own_statistics(*renderer, *renderer, camera.resized(320, 240), {});
}

TEST(ModePairs, are_counted_with_every_size_of_tiles) {
  const auto renderer = renderer_of(test::random_cloud(3000, 0, 5));
  for (const int tile_px : kTileSizes) {
    SCOPED_TRACE(tile_px);
    RenderSettings settings;
    settings.tile_px = tile_px;
    test::expect_own_statistics(*renderer, *renderer, test::front_camera(161, 117), settings);
  }
}

TEST(ModePairs, do_not_depend_on_the_mode_of_the_frame_or_the_number_of_threads) {
  const GaussianCloud cloud = test::random_cloud(9000, 0, 6);
  const Camera camera = test::front_camera(200, 150);
  const auto one = renderer_of(cloud, 1);
  const std::vector<ModePairs> expected = test::own_statistics(*one, camera, {});
  EXPECT_NE(expected[0].tile_pairs, expected[5].tile_pairs);
  for (const int threads : {1, 2, 5}) {
    const auto renderer = renderer_of(cloud, threads);
    RenderSettings settings;
    for (settings.mode = kReferenceMode; settings.mode <= mode_count(); ++settings.mode) {
      EXPECT_EQ(renderer->render(camera, settings, test::only_mode_pairs()).mode_pairs, expected)
          << mode_name(settings.mode) << " " << threads;
    }
  }
}

TEST(ModePairs, of_a_reduced_frame_can_be_those_of_the_full_size) {
  const auto renderer = renderer_of(test::random_cloud(4000, 0, 3));
  const CountedView full{test::front_camera(320, 200), {}};
  const std::vector<ModePairs> expected = test::own_statistics(*renderer, full.camera, {});
  Outputs outputs;
  outputs.mode_pairs = true;
  outputs.counted = full;
  RenderSettings small;
  small.dilation = kDilation / 9;
  const Frame& frame = renderer->render(full.camera.resized(106, 66), small, outputs);
  EXPECT_EQ(frame.mode_pairs, expected);
  EXPECT_EQ(frame.color.width, 106);
  EXPECT_LT(frame.stats.tile_pairs, expected[4].tile_pairs);
}

TEST(ModePairs, are_counted_only_when_asked_for_and_change_nothing_else) {
  const auto renderer = renderer_of(test::random_cloud(2000, 0, 10));
  const Camera camera = test::front_camera(90, 60);
  Outputs outputs;
  outputs.mode_pairs = outputs.used = outputs.pairs = true;
  const Frame with = renderer->render(camera, {}, outputs);
  EXPECT_FALSE(with.mode_pairs.empty());
  EXPECT_GT(with.stats.count_ms, 0);
  outputs.mode_pairs = false;
  const Frame& without = renderer->render(camera, {}, outputs);
  EXPECT_TRUE(without.mode_pairs.empty());
  EXPECT_EQ(without.stats.count_ms, 0);
  EXPECT_EQ(with.color.values, without.color.values);
  EXPECT_EQ(with.used, without.used);
  EXPECT_EQ(with.pairs, without.pairs);
  EXPECT_EQ(with.stats.tile_pairs, without.stats.tile_pairs);
}

TEST(ModePairs, of_the_frame_after_a_cancelled_one_are_right) {
  const auto renderer = renderer_of(test::random_cloud(2000, 0, 4));
  const Camera camera = test::front_camera(64, 64);
  for (const Pipeline pipeline : {Pipeline::classic, Pipeline::fast}) {
    RenderSettings settings;
    settings.pipeline = pipeline;
    std::stop_source source;
    source.request_stop();
    EXPECT_THROW(renderer->render(camera, settings, test::only_mode_pairs(), HostImage{},
                                  source.get_token()),
                 Cancelled);
    test::expect_own_statistics(*renderer, *renderer, camera, settings);
  }
}

}  // namespace
}  // namespace qs
