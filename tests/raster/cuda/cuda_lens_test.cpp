// SPDX-License-Identifier: MIT
// Frames through lenses on CUDA: the pictures and numbers of the CPU backend, and faces that are
// added up as the host adds them.
#include <cstdlib>
#include <vector>

#include "io/camera/lens_views.h"
#include "raster/cuda/renderer.h"
#include "raster/kernel/cull/table.h"
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
    outputs.pairs = outputs.used = outputs.evaluated = true;
    const Frame a = cpu->render(test::front_camera(width, height), settings, outputs);
    const Frame& b = gpu->render(test::front_camera(width, height), settings, outputs);
    EXPECT_EQ(b.stats.tile_pairs, a.stats.tile_pairs);
    EXPECT_EQ(b.stats.visible, a.stats.visible);
    EXPECT_EQ(b.mode_pairs, a.mode_pairs);
    EXPECT_EQ(b.pairs, a.pairs);
    EXPECT_EQ(b.used.size(), a.used.size());
    EXPECT_EQ(b.evaluated.size(), a.evaluated.size());
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

// Faces are drawn at the same time in several lanes, by buffers that hold the faces before them.
TEST_P(CudaLens, draws_the_same_bits_in_any_number_of_lanes) {
  const GaussianCloud cloud = test::surrounding_cloud(1500, 1, 8);
  LensView stereo = panorama_view(180), few = panorama_view(360);
  stereo.eye_distance = 0.1;
  few.faces = kFewFaces;
  const struct {
    LensView view;
    int width, height;
  } cases[] = {{panorama_view(360), 64, 32}, {stereo, 20, 40}, {few, 48, 24}};
  Outputs outputs;
  outputs.depth = true;
  outputs.mode_pairs = true;
  std::vector<Frame> alone;
  for (const char* lanes : {"1", "3", "100"}) {
    SCOPED_TRACE(lanes);
    setenv("QUADSPLAT_LANES", lanes, 1);
    const auto gpu = renderer_of(Backend::cuda, cloud);
    std::vector<Frame> drawn;
    for (const auto& [view, width, height] : cases) {
      RenderSettings settings = settings_of_pipeline();
      settings.lens = std::make_shared<const LensView>(view);
      for (const CullMode mode : {default_mode(), find_culler("3dgs")}) {
        settings.mode = mode;
        for (int again = 0; again < (mode == default_mode() ? 2 : 1); ++again)
          drawn.push_back(gpu->render(test::front_camera(width, height), settings, outputs));
        // A frame without a lens between them.
        drawn.push_back(gpu->render(test::front_camera(40, 30), settings_of_pipeline(), outputs));
      }
    }
    unsetenv("QUADSPLAT_LANES");
    if (alone.empty()) alone = drawn;
    for (std::size_t i = 0; i < alone.size(); ++i) {
      SCOPED_TRACE(i);
      EXPECT_EQ(drawn[i].color.values, alone[i].color.values);
      EXPECT_EQ(drawn[i].depth.alpha, alone[i].depth.alpha);
      EXPECT_EQ(drawn[i].depth.median, alone[i].depth.median);
      EXPECT_EQ(drawn[i].mode_pairs, alone[i].mode_pairs);
      EXPECT_EQ(drawn[i].stats.tile_pairs, alone[i].stats.tile_pairs);
      EXPECT_EQ(drawn[i].stats.pipeline, GetParam());
    }
  }
}

}  // namespace
}  // namespace qs
