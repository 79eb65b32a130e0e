// SPDX-License-Identifier: MIT
// Compares the CUDA backend with the CPU backend on generated scenes: equal decisions and images.
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "support/gpu.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace qs {
namespace {

class Cuda : public test::PipelineTest {
 protected:
  /// Settings that together cover every branch of preprocessing.
  static std::vector<RenderSettings> settings_to_try() {
    RenderSettings plain = settings_of_pipeline(), other = plain;
    other.antialiased = true;
    other.splat_scale = 0.6f;
    other.dilation = 0.02;
    other.sh_degree = 1;
    other.background = {0.2f, 0.4f, 0.9f};
    RenderSettings sharper = plain;  // the least dilation of CUDA's `fast`
    sharper.dilation = kDilation / 2;
    sharper.antialiased = true;
    return {plain, other, sharper};
  }
};

INSTANTIATE_TEST_SUITE_P(Pipelines, Cuda, test::kPipelines, test::name_of_pipeline);

constexpr std::pair<int, int> kSizes[] = {{1, 1}, {17, 33}, {96, 64}, {161, 23}, {320, 200}};

Outputs everything() {
  Outputs outputs;
  outputs.pairs = outputs.evaluated = outputs.used = outputs.trace = true;
  return outputs;
}

TEST_P(Cuda, decides_footprints_and_tile_lists_as_the_cpu_bit_for_bit) {
  for (int degree = 0; degree <= kMaxShDegree; ++degree) {
    const GaussianCloud cloud =
        test::random_cloud(3000, degree, 40 + static_cast<unsigned>(degree));
    const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
    const CullMode modes = degree == 0 ? mode_count() : culler_count();  // the peers once
    for (RenderSettings settings : settings_to_try()) {
      for (const auto& [width, height] : kSizes) {
        for (settings.mode = 1; settings.mode <= modes; ++settings.mode) {
          SCOPED_TRACE(testing::Message() << mode_name(settings.mode) << " " << width << "x"
                                          << height << " degree " << degree);
          const Camera camera = test::front_camera(width, height);
          test::expect_equal_decisions(gpu->render(camera, settings, test::decisions()),
                                       cpu->render(camera, settings, test::decisions()));
        }
      }
    }
  }
}

TEST_P(Cuda, decides_faces_and_orthographic_views_as_the_cpu_bit_for_bit) {
  for (const GaussianCloud& cloud :
       {test::random_cloud(3000, 2, 48), test::surrounding_cloud(3000, 1, 49)}) {
    const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
    for (RenderSettings settings : settings_to_try()) {
      settings.occlusion = settings.antialiased.has_value();
      for (const Projection projection : test::kOtherProjections) {
        Camera camera = test::with_projection(test::front_camera(96, 64), projection);
        camera.center_px.x = settings.occlusion ? 90 : -10;  // a face that was cut
        for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode) {
          SCOPED_TRACE(testing::Message()
                       << mode_name(settings.mode) << " " << static_cast<int>(projection));
          test::expect_equal_decisions(gpu->render(camera, settings, test::decisions()),
                                       cpu->render(camera, settings, test::decisions()));
          Outputs outputs;
          outputs.depth = true;
          const Frame a = cpu->render(camera, settings, outputs);
          const Frame& b = gpu->render(camera, settings, outputs);
          test::expect_same_image(b.color, a.color);
          for (std::size_t i = 0; i < a.depth.median.size(); ++i)
            ASSERT_NEAR(a.depth.expected[i], b.depth.expected[i], 1e-4f * a.depth.expected[i]);
        }
      }
    }
  }
}

TEST_P(Cuda, draws_the_image_of_the_cpu) {
  const GaussianCloud cloud = test::random_cloud(3000, 3, 42);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  for (RenderSettings settings : settings_to_try()) {
    for (const auto& [width, height] : kSizes) {
      for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode) {
        SCOPED_TRACE(testing::Message()
                     << mode_name(settings.mode) << " " << width << "x" << height);
        const Camera camera = test::front_camera(width, height);
        const Frame& a = cpu->render(camera, settings, everything());
        const Frame& b = gpu->render(camera, settings, everything());
        test::expect_same_image(b.color, a.color);
        // The entry at which a pixel stops may depend on the last bit of its transmittance.
        std::size_t different = 0;
        for (std::size_t i = 0; i < a.evaluated.size(); ++i)
          different += a.evaluated[i] != b.evaluated[i];
        EXPECT_LE(different, a.evaluated.size() / 1000);
      }
    }
  }
}

TEST_P(Cuda, leaves_the_used_pairs_of_the_cpu) {
  const GaussianCloud cloud = test::random_cloud(3000, 0, 44);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  RenderSettings settings = settings_of_pipeline();
  for (const auto& [width, height] : {std::pair{17, 33}, {161, 45}}) {
    for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode) {
      SCOPED_TRACE(testing::Message() << mode_name(settings.mode) << " " << width << "x" << height);
      const Camera camera = test::front_camera(width, height);
      const Frame& a = cpu->render(camera, settings, everything());
      const Frame& b = gpu->render(camera, settings, everything());
      ASSERT_EQ(b.used.size(), a.used.size());
      EXPECT_EQ(b.stats.used_pairs, sum_of(b.used));
      // Rounding may put an alpha close to 1/255 on either side.
      EXPECT_NEAR(static_cast<double>(*b.stats.used_pairs),
                  static_cast<double>(*a.stats.used_pairs),
                  1 + 1e-4 * static_cast<double>(a.stats.tile_pairs));
    }
  }
}

TEST_P(Cuda, leaves_the_used_pairs_of_the_cpu_on_the_bundled_scene) {
  const GaussianCloud cloud = test::read_scene(test::source_path("assets/plush.ply")).cloud;
  const Camera camera =
      read_cameras(test::source_path("assets/cameras.json")).front().resized(80, 60);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  Outputs only;
  only.color = false;
  only.used = true;
  RenderSettings settings = settings_of_pipeline();
  for (const char* mode : {"3dgs", "quadbox", "exact"}) {
    settings.mode = find_culler(mode);
    const RenderStats a = cpu->render(camera, settings, only).stats;
    const RenderStats b = gpu->render(camera, settings, only).stats;
    EXPECT_EQ(b.tile_pairs, a.tile_pairs);
    EXPECT_NEAR(static_cast<double>(*b.used_pairs), static_cast<double>(*a.used_pairs),
                1 + 1e-4 * static_cast<double>(a.tile_pairs - *a.used_pairs))
        << mode;
  }
}

TEST_P(Cuda, leaves_used_pairs_without_an_image_and_only_when_asked_for) {
  const auto gpu = renderer_of(Backend::cuda, test::random_cloud(1000, 0, 46));
  const Camera camera = test::front_camera(96, 64);
  const RenderSettings settings = settings_of_pipeline();
  const std::vector<std::uint32_t> used = gpu->render(camera, settings, everything()).used;
  Outputs only;
  only.color = false;
  only.used = true;
  EXPECT_EQ(gpu->render(camera, settings, only).used, used);
  EXPECT_TRUE(gpu->render(camera, settings).used.empty());
  EXPECT_FALSE(gpu->render(camera, settings).stats.used_pairs.has_value());
}

TEST_P(Cuda, leaves_the_splats_of_the_cpu_in_its_trace) {
  const GaussianCloud cloud = test::random_cloud(500, 3, 45);
  Outputs only;
  only.color = false;
  only.trace = true;
  const Camera camera = test::front_camera(96, 64);
  const Trace a =
      renderer_of(Backend::cpu, cloud)->render(camera, settings_of_pipeline(), only).trace;
  const Trace b =
      renderer_of(Backend::cuda, cloud)->render(camera, settings_of_pipeline(), only).trace;
  ASSERT_EQ(b.splats.size(), a.splats.size());
  for (std::size_t i = 0; i < a.splats.size(); ++i) {
    EXPECT_EQ(b.splats[i].mean_px, a.splats[i].mean_px);
    EXPECT_EQ(b.splats[i].log2_conic, a.splats[i].log2_conic);
    EXPECT_NEAR(b.splats[i].opacity, a.splats[i].opacity, 1e-5f);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(b.splats[i].color[c], a.splats[i].color[c], 1e-5f);
  }
}

TEST_P(Cuda, lossless_modes_are_within_80_db_of_the_reference) {
  const GaussianCloud cloud = test::random_cloud(3000, 3, 43);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  const Camera camera = test::front_camera(320, 200);
  RenderSettings settings = settings_of_pipeline();
  settings.mode = kReferenceMode;
  const Image reference = cpu->render(camera, settings).color;
  for (const CullMode mode : test::tiled_modes()) {
    if (!row_of(mode).lossless) continue;
    settings.mode = mode;
    EXPECT_GE(psnr_8bit(gpu->render(camera, settings).color, reference), 80.0) << mode_name(mode);
  }
}

TEST_P(Cuda, lossless_modes_are_equal_bit_for_bit) {
  const GaussianCloud cloud = test::random_cloud(4000, 1, 77);
  const auto gpu = renderer_of(Backend::cuda, cloud);
  const Camera camera = test::front_camera(320, 200);
  RenderSettings settings = settings_of_pipeline();
  settings.mode = find_culler("adr");
  const Image adr = gpu->render(camera, settings).color;
  for (const char* name : {"quadbox-naive", "quadbox", "exact"}) {
    settings.mode = find_culler(name);
    EXPECT_EQ(gpu->render(camera, settings).color.values, adr.values) << name;
  }
}

TEST_P(Cuda, two_runs_are_equal_bit_for_bit) {
  QS_EMULATED_BEFORE_A_RELEASE();
  const GaussianCloud cloud = test::random_cloud(20000, 2, 5);
  const Camera camera = test::front_camera(300, 180);
  const auto first = renderer_of(Backend::cuda, cloud), second = renderer_of(Backend::cuda, cloud);
  for (const CullMode mode : test::tiled_modes()) {
    RenderSettings settings = settings_of_pipeline();
    settings.mode = mode;
    const Frame a = first->render(camera, settings, everything());
    for (Renderer* renderer : {first.get(), second.get()}) {
      const Frame& b = renderer->render(camera, settings, everything());
      EXPECT_EQ(b.color.values, a.color.values) << mode_name(mode);
      EXPECT_EQ(b.evaluated, a.evaluated) << mode_name(mode);
      EXPECT_EQ(b.trace.listed, a.trace.listed) << mode_name(mode);
    }
  }
}

TEST_P(Cuda, draws_the_background_where_nothing_is_visible) {
  RenderSettings settings = settings_of_pipeline();
  settings.background = {0.25f, 0.5f, 0.75f};
  GaussianCloud behind = test::random_cloud(100, 0, 1);
  for (glm::vec3& position : behind.positions) position.z = -1;
  for (const GaussianCloud& cloud : {GaussianCloud{}, behind}) {
    const auto gpu = renderer_of(Backend::cuda, cloud);
    for (const auto& [width, height] : kSizes) {
      for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode) {
        const Frame& frame = gpu->render(test::front_camera(width, height), settings, everything());
        EXPECT_EQ(frame.color.at(width - 1, height - 1, 0), 0.25f);
        EXPECT_EQ(frame.color.at(0, 0, 2), 0.75f);
        EXPECT_EQ(frame.stats.visible, 0u);
        EXPECT_EQ(frame.stats.tile_pairs, 0u);
        EXPECT_EQ(frame.stats.max_pairs_in_a_tile, 0u);
        EXPECT_EQ(frame.trace.tile_begin.size(), static_cast<std::size_t>(frame.grid.count()) + 1);
        EXPECT_EQ(frame.trace.tile_begin.back(), 0u);
      }
    }
  }
}

TEST_P(Cuda, leaves_the_image_on_the_device_when_asked_to) {
  const auto gpu = renderer_of(Backend::cuda, test::random_cloud(500, 0, 3));
  const Frame& frame =
      gpu->render(test::front_camera(64, 48), settings_of_pipeline(), {}, DeviceImage{});
  EXPECT_TRUE(frame.color.values.empty());
  EXPECT_GT(frame.stats.tile_pairs, 0u);
}

TEST_P(Cuda, reports_stage_times_only_when_asked_to) {
  const auto gpu = renderer_of(Backend::cuda, test::random_cloud(5000, 3, 3));
  const Camera camera = test::front_camera(640, 480);
  const RenderStats plain = gpu->render(camera, settings_of_pipeline()).stats;
  EXPECT_GT(plain.frame_ms, 0);
  for (const float ms : plain.stage_ms) EXPECT_EQ(ms, 0);
  Outputs outputs;
  outputs.stage_times = true;
  const RenderStats marked = gpu->render(camera, settings_of_pipeline(), outputs).stats;
  const bool has_bin = GetParam() == Pipeline::classic;  // `fast` bins in preprocess and sort
  for (int stage = 0; stage < kStageCount; ++stage) {
    SCOPED_TRACE(kStageNames[stage]);
    if (!has_bin && stage == static_cast<int>(Stage::bin)) {
      EXPECT_EQ(marked.stage_ms[stage], 0);
    } else {
      EXPECT_GT(marked.stage_ms[stage], 0);
    }
  }
}

}  // namespace
}  // namespace qs
