// SPDX-License-Identifier: MIT
// Alpha and depth of the CUDA backend against the CPU backend.
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "support/depth_maps.h"
#include "support/gpu.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace qs {
namespace {

class CudaDepth : public test::PipelineTest {
 protected:
  static Outputs only_depth() {
    Outputs outputs;
    outputs.color = false;
    outputs.depth = true;
    return outputs;
  }
};

INSTANTIATE_TEST_SUITE_P(Pipelines, CudaDepth, test::kPipelines, test::name_of_pipeline);

TEST_P(CudaDepth, is_that_of_the_cpu_within_the_stated_bound) {
  const GaussianCloud cloud = test::random_cloud(3000, 0, 42);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  RenderSettings settings = settings_of_pipeline();
  for (const auto& [width, height] : {std::pair{1, 1}, {17, 33}, {161, 45}, {160, 100}}) {
    for (const char* mode : {"3dgs", "quadbox", "exact"}) {
      SCOPED_TRACE(testing::Message() << mode << " " << width << "x" << height);
      settings.mode = find_culler(mode);
      const Camera camera = test::front_camera(width, height);
      const DepthMaps expected = cpu->render(camera, settings, only_depth()).depth;
      test::expect_same_depth(gpu->render(camera, settings, only_depth()).depth, expected);
    }
  }
}

TEST_P(CudaDepth, of_the_bundled_scene_is_that_of_the_cpu) {
  const GaussianCloud cloud = test::read_scene(test::source_path("assets/plush.ply")).cloud;
  const Camera camera =
      read_cameras(test::source_path("assets/cameras.json")).front().resized(80, 60);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  const RenderSettings settings = settings_of_pipeline();
  const DepthMaps expected = cpu->render(camera, settings, only_depth()).depth;
  test::expect_same_depth(gpu->render(camera, settings, only_depth()).depth, expected);
}

TEST_P(CudaDepth, is_drawn_with_the_image_or_alone_and_only_when_asked_for) {
  const GaussianCloud cloud = test::random_cloud(1500, 0, 46);
  const auto gpu = renderer_of(Backend::cuda, cloud);
  const Camera camera = test::front_camera(96, 64);
  const RenderSettings settings = settings_of_pipeline();
  const DepthMaps alone = gpu->render(camera, settings, only_depth()).depth;
  Outputs both;
  both.depth = true;
  const Frame frame = gpu->render(camera, settings, both);
  EXPECT_TRUE(test::equal(frame.depth, alone));
  const Frame& plain = gpu->render(camera, settings);
  EXPECT_EQ(plain.color.values, frame.color.values);
  EXPECT_TRUE(plain.depth.alpha.empty());
}

TEST_P(CudaDepth, of_an_empty_scene_and_of_a_view_of_nothing_is_zero) {
  GaussianCloud empty;
  empty.resize(0, 0);
  const Camera camera = test::front_camera(40, 24);
  for (const GaussianCloud& cloud :
       {empty, test::single_gaussian({0, 0, -3}, 0.5f, {1, 1, 1}, 2)}) {
    const auto gpu = renderer_of(Backend::cuda, cloud);
    const DepthMaps maps = gpu->render(camera, settings_of_pipeline(), only_depth()).depth;
    for (const std::vector<float>* map : {&maps.alpha, &maps.expected, &maps.median})
      EXPECT_EQ(*map, std::vector<float>(40 * 24));
  }
}

}  // namespace
}  // namespace qs
