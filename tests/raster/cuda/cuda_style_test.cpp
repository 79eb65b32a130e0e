// SPDX-License-Identifier: MIT
// The styles points and ellipsoids of the CUDA backend against the CPU backend.
#include "support/depth_maps.h"
#include "support/gpu.h"
#include "support/mode_pairs.h"
#include "support/scenes.h"

namespace qs {
namespace {

class CudaStyle : public test::PipelineTest {
 protected:
  static Outputs everything() {
    Outputs outputs;
    outputs.pairs = outputs.evaluated = outputs.used = outputs.trace = outputs.depth = true;
    return outputs;
  }
};

INSTANTIATE_TEST_SUITE_P(Pipelines, CudaStyle, test::kPipelines, test::name_of_pipeline);

constexpr DrawStyle kSolidStyles[] = {DrawStyle::points, DrawStyle::ellipsoids};

TEST_P(CudaStyle, decides_and_draws_as_the_cpu_in_every_mode) {
  const GaussianCloud cloud = test::random_cloud(2000, 1, 42);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  for (const auto& [width, height] : {std::pair{17, 33}, {96, 64}}) {
    const Camera camera = test::front_camera(width, height);
    for (const DrawStyle style : kSolidStyles) {
      RenderSettings settings = settings_of_pipeline();
      settings.style = style;
      settings.background = {0.2f, 0.4f, 0.9f};
      for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode) {
        SCOPED_TRACE(testing::Message() << kDrawStyleNames[static_cast<int>(style)] << " "
                                        << mode_name(settings.mode) << " " << width);
        const Frame& a = cpu->render(camera, settings, everything());
        const Frame& b = gpu->render(camera, settings, everything());
        test::expect_equal_decisions(b, a);
        test::expect_same_image(b.color, a.color);
        EXPECT_LE(test::share_beyond(b.depth.alpha, a.depth.alpha, 0.005), 1e-3);
        EXPECT_LE(test::share_beyond(b.depth.expected, a.depth.expected, 0.005), 1e-3);
        EXPECT_NEAR(static_cast<double>(*b.stats.used_pairs),
                    static_cast<double>(*a.stats.used_pairs),
                    1 + 1e-4 * static_cast<double>(a.stats.tile_pairs));
        test::expect_same_image(gpu->render(camera, settings).color, a.color);  // other kernels
      }
      test::expect_own_statistics(*gpu, *cpu, camera, settings);
    }
  }
}

TEST_P(CudaStyle, draws_long_lists_as_the_cpu) {
  constexpr int kPictureSide = 40;
  const GaussianCloud cloud = test::scattered_cloud(
      6000, kPictureSide, [](std::size_t i) { return 2 + 1e-3 * static_cast<double>(i); });
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  const Camera camera = test::front_camera(kPictureSide, kPictureSide);
  for (const DrawStyle style : kSolidStyles) {
    RenderSettings settings = settings_of_pipeline();
    settings.style = style;
    settings.splat_scale = style == DrawStyle::points ? 0.6f : 0.05f;
    const Frame& frame = gpu->render(camera, settings);
    EXPECT_GT(frame.stats.max_pairs_in_a_tile, 768u);
    test::expect_same_image(frame.color, cpu->render(camera, settings).color);
  }
}

TEST_P(CudaStyle, draws_a_scene_of_one_gaussian) {
  const GaussianCloud cloud = test::single_gaussian({0, 0, 3}, 0.5f, {1, 1, 1}, -1);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  const Camera camera = test::front_camera(65, 65);
  for (const DrawStyle style : kSolidStyles) {
    for (const float scale : {1.0f, 9.0f}) {
      RenderSettings settings = settings_of_pipeline();
      settings.style = style;
      settings.splat_scale = scale;
      const Frame& frame = gpu->render(camera, settings);
      EXPECT_NEAR(frame.color.at(32, 32, 0), 0.99, 1e-5);
      // Rounding moves a white edge by less than two steps of 8 bits.
      EXPECT_EQ(test::share_beyond(frame.color, cpu->render(camera, settings).color, 1.5 / 255), 0);
    }
  }
}

}  // namespace
}  // namespace qs
