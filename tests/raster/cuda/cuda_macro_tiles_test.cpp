// SPDX-License-Identifier: MIT
// Lists of pipeline `fast` by macro-tile equal the CPU's lists: in macro-tiles that are usual, full
// or too full, with equal depths, with Gaussians of all sizes, and when the view changes between
// them.
#include "support/gpu.h"
#include "support/scenes.h"

namespace qs {
namespace {

class CudaMacroTiles : public test::PipelineTest {
 protected:
  void SetUp() override {
    test::PipelineTest::SetUp();
    if (GetParam() == Pipeline::classic) GTEST_SKIP() << "pipeline classic has no macro-tiles";
  }
};

INSTANTIATE_TEST_SUITE_P(Pipelines, CudaMacroTiles, test::kPipelines, test::name_of_pipeline);

void expect_lists_of_the_cpu(Renderer& cpu, Renderer& gpu, const Camera& camera,
                             RenderSettings settings) {
  for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode) {
    SCOPED_TRACE(mode_name(settings.mode));
    test::expect_equal_decisions(gpu.render(camera, settings, test::decisions()),
                                 cpu.render(camera, settings, test::decisions()));
  }
}

/// Gaussians in usual macro-tiles, in fuller macro-tiles, and more than shared memory holds (on any
/// GPU).
constexpr std::size_t kFills[] = {800, 3400, 30'000};

TEST_P(CudaMacroTiles, list_the_tiles_of_the_cpu_however_full_they_are) {
  for (const std::size_t fill : kFills) {
    SCOPED_TRACE(fill);
    const GaussianCloud cloud = test::scattered_cloud(
        fill, 32, [](std::size_t i) { return 2 + 1e-4 * double(i * 7919 % 9973); });
    const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
    expect_lists_of_the_cpu(*cpu, *gpu, test::front_camera(32, 32), settings_of_pipeline());
  }
}

TEST_P(CudaMacroTiles, are_cut_by_more_samples_than_shared_memory_holds) {
  if (!test::gpu_is_emulated()) GTEST_SKIP() << "needs millions of Gaussians on a GPU";
  const GaussianCloud cloud = test::scattered_cloud(
      430'000, 32, [](std::size_t i) { return 2 + 1e-5 * double(i * 7919 % 99'991); });
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  const Camera camera = test::front_camera(32, 32);
  test::expect_equal_decisions(gpu->render(camera, settings_of_pipeline(), test::decisions()),
                               cpu->render(camera, settings_of_pipeline(), test::decisions()));
}

TEST_P(CudaMacroTiles, put_equal_depths_in_the_order_of_the_file) {
  for (const std::size_t planes : {1u, 3u, 400u}) {
    SCOPED_TRACE(planes);
    const GaussianCloud cloud = test::scattered_cloud(
        4000, 48, [&](std::size_t i) { return 3 + 0.01 * double(i * 7919 % planes); });
    const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
    expect_lists_of_the_cpu(*cpu, *gpu, test::front_camera(48, 48), settings_of_pipeline());
  }
}

TEST_P(CudaMacroTiles, list_large_gaussians_in_large_pictures) {
  const GaussianCloud cloud =
      test::scattered_cloud(3000, 900, [](std::size_t i) { return 2 + 0.001 * double(i); });
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  for (const auto& [width, height] : {std::pair{900, 900}, {1700, 40}, {40, 1700}}) {
    SCOPED_TRACE(testing::Message() << width << "x" << height);
    expect_lists_of_the_cpu(*cpu, *gpu, test::front_camera(width, height), settings_of_pipeline());
  }
}

// A Gaussian is appended by its warp if it meets few macro-tiles, and by a warp or a block of its
// own if it meets more.
TEST_P(CudaMacroTiles, list_a_gaussian_that_meets_few_or_many_macro_tiles) {
  const Camera camera = test::front_camera(900, 900);
  struct Case {
    double radius_px;
    std::uint64_t least, most;  // macro-tiles
  };
  for (const Case& c : {Case{60, 2, 16}, {150, 17, 128}, {400, 129, 435}}) {
    SCOPED_TRACE(c.radius_px);
    const double sigma = c.radius_px / 3.3 * 3 / camera.focal_px.x;
    const GaussianCloud cloud =
        test::single_gaussian({0, 0, 3}, static_cast<float>(sigma), {1, 1, 1}, 5);
    const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
    expect_lists_of_the_cpu(*cpu, *gpu, camera, settings_of_pipeline());
    RenderSettings settings = settings_of_pipeline();
    settings.mode = find_culler("exact");
    const std::uint64_t entries = gpu->render(camera, settings).stats.sort_bytes / 8;
    EXPECT_GE(entries, c.least);
    EXPECT_LE(entries, c.most);
  }
}

// A block of Gaussians has a counter for each of 2,048 macro-tiles, and a hash table for more.
TEST_P(CudaMacroTiles, list_the_tiles_of_the_cpu_in_pictures_of_every_size) {
  const GaussianCloud cloud =
      test::scattered_cloud(1500, 4000, [](std::size_t i) { return 2 + 0.001 * double(i); });
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  for (const auto& [width, height] : {std::pair{16384, 256}, {16384, 288}, {80, 16384}}) {
    SCOPED_TRACE(testing::Message() << width << "x" << height);
    const Camera camera = test::front_camera(width, height);
    const Frame& frame = gpu->render(camera, settings_of_pipeline(), test::decisions());
    EXPECT_EQ(frame.stats.pipeline, Pipeline::fast);
    EXPECT_GE(frame.stats.sort_bytes, 8u * frame.stats.visible);
    EXPECT_LT(frame.stats.sort_bytes, 8u * frame.stats.tile_pairs);
    test::expect_equal_decisions(frame,
                                 cpu->render(camera, settings_of_pipeline(), test::decisions()));
  }
}

TEST_P(CudaMacroTiles, draw_the_largest_picture) {
  if (test::gpu_is_emulated()) GTEST_SKIP() << "needs gigabytes on a GPU";
  const auto gpu = renderer_of(Backend::cuda, test::random_cloud(3000, 0, 3));
  for (const int side : {8192, 16384}) {
    SCOPED_TRACE(side);
    const Frame& frame =
        gpu->render(test::front_camera(side, side), settings_of_pipeline(), {}, DeviceImage{});
    EXPECT_EQ(frame.stats.pipeline, Pipeline::fast);
    EXPECT_GT(frame.stats.tile_pairs, 0u);
  }
}

TEST_P(CudaMacroTiles, of_a_larger_picture_are_left_to_classic_and_the_statistics_say_so) {
  QS_EMULATED_BEFORE_A_RELEASE();
  const auto gpu =
      renderer_of(Backend::cuda, test::single_gaussian({0, 0, 3}, 1e-4f, {1, 1, 1}, 2));
  Outputs counts;
  counts.color = false;
  const Frame& frame =
      gpu->render(test::front_camera(16'400, 16'384), settings_of_pipeline(), counts);
  EXPECT_EQ(frame.stats.pipeline, Pipeline::classic);
  EXPECT_EQ(frame.stats.visible, 1u);
}

TEST_P(CudaMacroTiles, are_cut_into_slices_in_far_views_and_whole_in_near_ones) {
  const GaussianCloud cloud =
      test::scattered_cloud(30'000, 512, [](std::size_t i) { return 2 + 1e-4 * double(i); });
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  for (const int side : {512, 16, 512, 24, 300, 512}) {
    SCOPED_TRACE(side);
    expect_lists_of_the_cpu(*cpu, *gpu, test::front_camera(side, side), settings_of_pipeline());
  }
}

// After the emptier view there are too few samples for the fuller view. They are samples of the
// farthest Gaussians, because these are projected first.
TEST_P(CudaMacroTiles, draw_the_same_picture_after_emptier_ones) {
  const std::size_t count = test::gpu_is_emulated() ? 24'000 : 300'000;
  const GaussianCloud cloud = test::scattered_cloud(
      count, 128, [](std::size_t i) { return 2 + 0.01 * double(i * 7919 % 9973); });
  const Camera emptier = test::front_camera(128, 128), fuller = test::front_camera(32, 32);
  const auto picture_of = [&](Renderer& gpu) {
    return gpu.render(fuller, settings_of_pipeline()).color.values;
  };
  const std::vector<float> expected = picture_of(*renderer_of(Backend::cuda, cloud));
  const auto gpu = renderer_of(Backend::cuda, cloud);
  for (int turn = 0; turn < 4; ++turn) {
    SCOPED_TRACE(turn);
    gpu->render(emptier, settings_of_pipeline());
    EXPECT_EQ(picture_of(*gpu), expected);
  }
}

// The slices of the second macro-tile exceed the memory that the smaller scene needed.
TEST_P(CudaMacroTiles, need_more_slices_after_a_larger_scene_has_come) {
  const auto cloud_of = [](std::size_t count) {
    return test::scattered_cloud(count, 64,
                                 [](std::size_t i) { return 2 + 1e-4 * double(i * 7919 % 9973); });
  };
  const std::size_t count = test::gpu_is_emulated() ? 180'000 : 600'000;
  const Camera camera = test::front_camera(64, 64);
  const auto gpu = renderer_of(Backend::cuda, cloud_of(66'000));
  gpu->render(camera, settings_of_pipeline());
  gpu->upload(cloud_of(count), {});
  const std::vector<float> drawn = gpu->render(camera, settings_of_pipeline()).color.values;
  const auto fresh = renderer_of(Backend::cuda, cloud_of(count));
  EXPECT_EQ(drawn, fresh->render(camera, settings_of_pipeline()).color.values);
}

}  // namespace
}  // namespace qs
