// SPDX-License-Identifier: MIT
// The CUDA backend reports input that is too large or wrong in one sentence, stops cancelled work,
// and can be used again afterwards.
#include <random>

#include <gmock/gmock.h>

#include "raster/clock/gpu_clock.h"
#include "support/gpu.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class CudaRobustness : public test::PipelineTest {
 protected:
  /// The message of the Error(device) that `work` throws.
  template <class Work>
  static std::string message_of(const Work& work) {
    try {
      work();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::device);
      return error.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
  }
};

INSTANTIATE_TEST_SUITE_P(Pipelines, CudaRobustness, test::kPipelines, test::name_of_pipeline);

/// `count` Gaussians, each of which covers every tile of any image.
GaussianCloud screen_filling_cloud(std::size_t count) {
  GaussianCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    test::append(cloud, test::single_gaussian({0, 0, 3}, 1000.0f, {0.5f, 0.5f, 0.5f}, 0.0f));
  }
  return cloud;
}

TEST_P(CudaRobustness, an_image_that_does_not_fit_is_refused_with_needed_and_free_memory) {
  const auto gpu = renderer_of(Backend::cuda, test::random_cloud(500, 0, 6));
  const Camera small = test::front_camera(64, 48);
  const Image before = gpu->render(small, settings_of_pipeline()).color;
  Camera camera = test::front_camera(200'000, 200'000);
  camera.focal_px = glm::dvec2(100);  // the scene covers only a small part
  EXPECT_THAT(message_of([&] { gpu->render(camera, settings_of_pipeline()); }),
              AllOf(HasSubstr("image"), HasSubstr("457763 MiB are needed"), HasSubstr("are free")));
  EXPECT_EQ(gpu->render(small, settings_of_pipeline()).color.values, before.values);
}

TEST_P(CudaRobustness, more_pairs_than_can_be_indexed_are_counted_right_and_refused) {
  const auto gpu = renderer_of(Backend::cuda, screen_filling_cloud(140));
  Outputs counts;
  counts.color = false;
  const Camera small = test::front_camera(64, 48);
  const Image before = gpu->render(small, settings_of_pipeline()).color;
  EXPECT_THAT(message_of([&] {
                gpu->render(test::front_camera(65'536, 65'536), settings_of_pipeline(), counts);
              }),
              AllOf(HasSubstr("2348810240 tile pairs"), HasSubstr("2147483647")));
  EXPECT_EQ(gpu->render(small, settings_of_pipeline()).color.values, before.values);
}

TEST_P(CudaRobustness, pairs_that_do_not_fit_are_refused_with_needed_and_free_memory) {
  // 1000 * 2^20 pairs of at least 12 bytes: more than 11 GiB. `classic` draws pictures of this
  // size.
  if (gpu_report().gpus[0].free_bytes >= std::uint64_t{11} << 30) {
    GTEST_SKIP() << "this GPU has memory for as many pairs as can be indexed";
  }
  const auto gpu = renderer_of(Backend::cuda, screen_filling_cloud(1000));
  Outputs counts;
  counts.color = false;
  EXPECT_THAT(message_of([&] {
                gpu->render(test::front_camera(16'400, 16'384), settings_of_pipeline(), counts);
              }),
              AllOf(HasSubstr("tile pairs"), HasSubstr("MiB are needed")));
  EXPECT_NO_THROW(gpu->render(test::front_camera(64, 48), settings_of_pipeline()));
}

TEST_P(CudaRobustness, the_reference_is_left_to_the_cpu) {
  const auto gpu = renderer_of(Backend::cuda, test::random_cloud(10, 0, 6));
  RenderSettings settings = settings_of_pipeline();
  settings.mode = kReferenceMode;
  EXPECT_THAT(message_of([&] { gpu->render(test::front_camera(8, 8), settings); }),
              HasSubstr("backend cpu only"));
}

TEST_P(CudaRobustness, a_gpu_that_is_not_there_is_refused) {
  EXPECT_THAT(message_of([] { make_renderer(Backend::cuda, test::pool(), 99); }),
              HasSubstr("there is no GPU 99"));
}

TEST_P(CudaRobustness, a_cancelled_frame_throws_and_the_next_one_is_right) {
  const GaussianCloud cloud = test::random_cloud(2000, 0, 4);
  const Camera camera = test::front_camera(64, 64);
  const auto gpu = renderer_of(Backend::cuda, cloud);
  const Image expected = gpu->render(camera, settings_of_pipeline()).color;
  std::stop_source source;
  source.request_stop();
  EXPECT_THROW(gpu->render(camera, settings_of_pipeline(), {}, HostImage{}, source.get_token()),
               Cancelled);
  EXPECT_EQ(gpu->render(camera, settings_of_pipeline()).color.values, expected.values);
}

TEST_P(CudaRobustness, a_cancelled_upload_leaves_the_old_scene_and_the_next_one_is_right) {
  const GaussianCloud cloud = test::random_cloud(2000, 1, 4);
  const Camera camera = test::front_camera(64, 64);
  const auto gpu = renderer_of(Backend::cuda, cloud);
  const Image expected = gpu->render(camera, settings_of_pipeline()).color;
  std::stop_source source;
  Progress progress;
  progress.stop = source.get_token();
  source.request_stop();
  EXPECT_THROW(gpu->upload(test::random_cloud(2000, 1, 5), progress), Cancelled);
  EXPECT_EQ(gpu->render(camera, settings_of_pipeline()).color.values, expected.values);
  gpu->upload(cloud, {});
  EXPECT_EQ(gpu->render(camera, settings_of_pipeline()).color.values, expected.values);
}

TEST_P(CudaRobustness, a_thousand_random_frames_leave_memory_and_images_as_they_were) {
  QS_NEEDS_REAL_GPU("the emulator takes minutes for a thousand frames");
  const auto gpu = renderer_of(Backend::cuda, test::random_cloud(3000, 2, 12));
  const auto free_bytes = [] { return gpu_report().gpus[0].free_bytes; };
  Outputs outputs;
  outputs.evaluated = true;
  std::vector<Image> expected;
  for (const CullMode mode : test::tiled_modes()) {
    RenderSettings settings = settings_of_pipeline();
    settings.mode = mode;
    // Lets every buffer reach its final size, and loads the kernels for small and large frames.
    for (const auto& [width, height] : {std::pair{1, 1}, {64, 48}, {320, 240}, {1280, 960}}) {
      gpu->render(test::front_camera(width, height), settings, outputs);
    }
    expected.push_back(gpu->render(test::front_camera(200, 150), settings).color);
  }
  const std::uint64_t before = free_bytes();

  std::mt19937 random(1);
  const auto draw = [&](int low, int high) {
    return std::uniform_int_distribution<int>(low, high)(random);
  };
  for (int i = 0; i < 1000; ++i) {
    RenderSettings settings = settings_of_pipeline();
    settings.mode = draw(1, culler_count());
    Camera camera = test::front_camera(draw(1, 480), draw(1, 360));
    camera.view_from_world[3] = glm::dvec3(draw(-50, 50), draw(-50, 50), draw(0, 200)) * 0.01;
    gpu->render(camera, settings, outputs, i % 2 == 0 ? Target(DeviceImage{}) : HostImage{});
  }

  EXPECT_EQ(free_bytes(), before);
  for (const CullMode mode : test::tiled_modes()) {
    RenderSettings settings = settings_of_pipeline();
    settings.mode = mode;
    EXPECT_EQ(gpu->render(test::front_camera(200, 150), settings).color.values,
              expected[static_cast<std::size_t>(mode - 1)].values);
  }
}

TEST(GpuReport, says_in_a_sentence_why_no_gpu_can_be_used_or_lists_them) {
  const GpuReport report = gpu_report();
  if (report.problem.empty()) {
    ASSERT_FALSE(report.gpus.empty());
    EXPECT_FALSE(report.driver.empty());
    EXPECT_GT(report.gpus[0].total_bytes, 0u);
    EXPECT_EQ(available_backends().front(), Backend::cuda);
  } else {
    EXPECT_GT(report.problem.size(), 20u);
    EXPECT_EQ(available_backends().size(), 1u);
    try {
      make_renderer(Backend::cuda, test::pool());
      ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::device);
      EXPECT_THAT(error.what(), HasSubstr(report.problem));
    }
  }
  EXPECT_EQ(available_backends().back(), Backend::cpu);
}

TEST(GpuReport, the_clock_of_a_gpu_is_positive_and_at_most_its_maximum) {
  const GpuSensors sensors = gpu_sensors(0);
  if (!sensors.read) GTEST_SKIP() << "no GPU, or its driver has no management library";
  const std::optional<GpuReading> reading = sensors.read();
  ASSERT_TRUE(reading);
  EXPECT_GT(reading->sm_mhz, 0);
  ASSERT_TRUE(sensors.sm_mhz_max);
  EXPECT_LE(reading->sm_mhz, *sensors.sm_mhz_max);
  EXPECT_FALSE(gpu_sensors(static_cast<int>(gpu_report().gpus.size())).read);
}

}  // namespace
}  // namespace qs
