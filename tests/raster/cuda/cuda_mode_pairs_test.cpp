// SPDX-License-Identifier: MIT
// Outputs::mode_pairs of the CUDA backend: every count is the statistic of that mode's own frame,
// and equals the count of the CPU backend.
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "support/gpu.h"
#include "support/mode_pairs.h"
#include "support/scene_files.h"
#include "support/shared.h"

namespace qs {
namespace {

class CudaModePairs : public test::PipelineTest {};

INSTANTIATE_TEST_SUITE_P(Pipelines, CudaModePairs, test::kPipelines, test::name_of_pipeline);

TEST_P(CudaModePairs, are_the_statistics_of_the_own_frame_of_each_mode_and_those_of_the_cpu) {
  for (test::CountedScene& scene : test::counted_scenes(1500)) {
    SCOPED_TRACE(scene.name);
    scene.settings.pipeline = GetParam();
    const auto cpu = renderer_of(Backend::cpu, scene.cloud);
    const auto gpu = renderer_of(Backend::cuda, scene.cloud);
    test::expect_own_statistics(*gpu, *gpu, scene.camera, scene.settings);
    test::expect_own_statistics(*gpu, *cpu, scene.camera, scene.settings);
  }
}

TEST_P(CudaModePairs, of_the_bundled_scene_are_those_of_the_cpu) {
  const GaussianCloud cloud = test::read_scene(test::source_path("assets/plush.ply")).cloud;
  const Camera camera =
      read_cameras(test::source_path("assets/cameras.json")).front().resized(320, 240);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  test::expect_own_statistics(*gpu, *cpu, camera, settings_of_pipeline());
}

TEST_P(CudaModePairs, arrive_with_the_picture_of_every_mode_and_only_when_asked_for) {
  const auto gpu = renderer_of(Backend::cuda, test::random_cloud(1500, 0, 46));
  const Camera camera = test::front_camera(96, 64);
  RenderSettings settings = settings_of_pipeline();
  const std::vector<ModePairs> expected = test::own_statistics(*gpu, camera, settings);
  Outputs outputs;
  outputs.mode_pairs = true;
  for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode) {
    const Frame counted = gpu->render(camera, settings, outputs);
    EXPECT_EQ(counted.mode_pairs, expected) << mode_name(settings.mode);
    const Frame& plain = gpu->render(camera, settings);
    EXPECT_EQ(plain.color.values, counted.color.values);
    EXPECT_TRUE(plain.mode_pairs.empty());
  }
}

TEST_P(CudaModePairs, of_a_reduced_frame_can_be_those_of_the_full_size) {
  const auto gpu = renderer_of(Backend::cuda, test::random_cloud(1500, 0, 3));
  Outputs outputs = test::only_mode_pairs();
  outputs.counted = CountedView{test::front_camera(320, 200), settings_of_pipeline()};
  RenderSettings small = settings_of_pipeline();
  small.dilation = kDilation / 9;
  const Camera& full = outputs.counted->camera;
  const std::vector<ModePairs> expected = test::own_statistics(*gpu, full, settings_of_pipeline());
  EXPECT_EQ(gpu->render(full.resized(106, 66), small, outputs).mode_pairs, expected);
}

TEST_P(CudaModePairs, of_a_frame_that_is_drawn_again_with_larger_buffers_are_counted_once) {
  GaussianCloud cloud;
  for (int i = 0; i < 100; ++i)
    test::append(cloud, test::single_gaussian({0, 0, 3}, 1000, {0.5f, 0.5f, 0.5f}, 0));
  // 120,000 pairs; the buffers begin with room for 65,536.
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  test::expect_own_statistics(*gpu, *cpu, test::front_camera(640, 480), settings_of_pipeline());
}

TEST_P(CudaModePairs, of_the_frame_after_a_cancelled_one_are_right) {
  const auto gpu = renderer_of(Backend::cuda, test::random_cloud(1000, 0, 4));
  const Camera camera = test::front_camera(64, 64);
  std::stop_source source;
  source.request_stop();
  EXPECT_THROW(gpu->render(camera, settings_of_pipeline(), test::only_mode_pairs(), HostImage{},
                           source.get_token()),
               Cancelled);
  test::expect_own_statistics(*gpu, *gpu, camera, settings_of_pipeline());
}

}  // namespace
}  // namespace qs
