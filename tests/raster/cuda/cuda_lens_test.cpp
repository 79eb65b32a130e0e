// SPDX-License-Identifier: MIT
// Frames through lenses on CUDA: the pictures and numbers of the CPU backend.
#include "io/camera/lens_views.h"
#include "support/gpu.h"
#include "support/scenes.h"

namespace qs {
namespace {

class CudaLens : public test::PipelineTest {};

INSTANTIATE_TEST_SUITE_P(Pipelines, CudaLens, test::kPipelines, test::name_of_pipeline);

TEST_P(CudaLens, draws_the_picture_of_the_cpu) {
  const GaussianCloud cloud = test::surrounding_cloud(1500, 1, 8);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  LensView stereo = panorama_view(180);
  stereo.eye_distance = 0.1;
  const struct {
    LensView view;
    int width, height;
  } cases[] = {{panorama_view(360), 96, 48},
               {stereo, 32, 64},
               {fisheye_view(220), 60, 50},
               {parallel_view(20), 60, 50}};
  for (const auto& [view, width, height] : cases) {
    SCOPED_TRACE(view.text);
    RenderSettings settings = settings_of_pipeline();
    settings.lens = std::make_shared<const LensView>(view);
    Outputs outputs;
    outputs.depth = true;
    outputs.mode_pairs = true;
    const Frame a = cpu->render(test::front_camera(width, height), settings, outputs);
    for (const Target& target : {Target(HostImage{}), Target(DeviceImage{})}) {
      if (view.is_parallel() && std::holds_alternative<DeviceImage>(target)) continue;
      const Frame& b = gpu->render(test::front_camera(width, height), settings, outputs, target);
      EXPECT_EQ(b.stats.tile_pairs, a.stats.tile_pairs);
      EXPECT_EQ(b.stats.visible, a.stats.visible);
      EXPECT_EQ(b.mode_pairs, a.mode_pairs);
      test::expect_same_image(b.color, a.color);
      for (std::size_t i = 0; i < a.depth.alpha.size(); ++i)
        ASSERT_NEAR(a.depth.alpha[i], b.depth.alpha[i], 1e-4f);
    }
  }
}

}  // namespace
}  // namespace qs
