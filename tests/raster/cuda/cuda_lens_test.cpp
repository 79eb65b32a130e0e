// SPDX-License-Identifier: MIT
// Frames through lenses on CUDA: the pictures and numbers of the CPU backend, and faces that are
// added up as the host adds them.
#include "io/camera/lens_views.h"
#include "raster/cuda/renderer.h"
#include "raster/lens/lens_renderer.h"
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
    const Frame& b = gpu->render(test::front_camera(width, height), settings, outputs);
    EXPECT_EQ(b.stats.tile_pairs, a.stats.tile_pairs);
    EXPECT_EQ(b.stats.visible, a.stats.visible);
    EXPECT_EQ(b.mode_pairs, a.mode_pairs);
    test::expect_same_image(b.color, a.color);
    for (std::size_t i = 0; i < a.depth.alpha.size(); ++i)
      ASSERT_NEAR(a.depth.alpha[i], b.depth.alpha[i], 1e-4f);
  }
}

TEST_P(CudaLens, adds_faces_up_with_the_bits_of_the_host) {
  const GaussianCloud cloud = test::surrounding_cloud(1500, 1, 8);
  const auto gpu = renderer_of(Backend::cuda, cloud);
  const auto by_host = with_lenses(make_cuda_renderer(test::pool(), 0), test::pool());
  by_host->upload(cloud, {});
  LensView stereo = panorama_view(180), few = fisheye_view(300);
  stereo.eye_distance = 0.1;
  few.faces = kFewFaces;
  // More than kMostMaps, so that copies of maps are dropped and made again.
  const struct {
    LensView view;
    int width, height;
  } cases[] = {{stereo, 20, 40}, {few, 41, 30}, {fisheye_view(60), 30, 41}, {stereo, 20, 40}};
  for (const auto& [view, width, height] : cases) {
    SCOPED_TRACE(view.text);
    RenderSettings settings = settings_of_pipeline();
    settings.background = {0.1f, 0.2f, 0.3f};
    settings.lens = std::make_shared<const LensView>(view);
    for (const bool color : {true, false}) {
      for (const bool depth : {true, false}) {
        if (!color && !depth) continue;
        Outputs outputs;
        outputs.color = color;
        outputs.depth = depth;
        const Camera camera = test::front_camera(width, height);
        const Frame& a = by_host->render(camera, settings, outputs);
        const Frame& b = gpu->render(camera, settings, outputs);
        EXPECT_EQ(a.color.values.size(), color ? 3u * static_cast<unsigned>(width * height) : 0u);
        EXPECT_EQ(b.color.values, a.color.values);
        EXPECT_EQ(b.depth.alpha, a.depth.alpha);
        EXPECT_EQ(b.depth.expected, a.depth.expected);
        EXPECT_EQ(b.depth.median, a.depth.median);
        EXPECT_EQ(b.stats.tile_pairs, a.stats.tile_pairs);
      }
    }
  }
}

}  // namespace
}  // namespace qs
