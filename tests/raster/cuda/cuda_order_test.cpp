// SPDX-License-Identifier: MIT
// The order in which the CUDA backend stores a scene changes no result: pipeline `fast` skips
// blocks of Gaussians that a view cannot show, and lists Gaussians in the order of the file.
// Coefficients that are stored as halves have the same colours.
#include <algorithm>
#include <cmath>
#include <random>

#include "raster/kernel/half.h"
#include "support/gpu.h"
#include "support/scenes.h"

namespace qs {
namespace {

class CudaOrder : public test::PipelineTest {};

INSTANTIATE_TEST_SUITE_P(Pipelines, CudaOrder, test::kPipelines, test::name_of_pipeline);

/// A camera in the centre of surrounding_cloud() that looks in direction number `way`.
Camera inside(int way, double vertical_fov) {
  const glm::dvec3 ways[] = {{1, 0, 0}, {-1, 0.1, 0}, {0, 1, 0}, {0, 0.1, 1}, {0, 0, -1}};
  return look_at({0, 0, 0}, ways[way], {0.3, 0.2, 0.9}, vertical_fov, 160, 120);
}

TEST_P(CudaOrder, lists_of_a_camera_inside_the_scene_equal_those_of_the_cpu) {
  GaussianCloud cloud = test::surrounding_cloud(20'000, 0, 4);
  for (std::size_t i = 0; i < 5; ++i) cloud.log_scales[i * 3000] += 5.0f;
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  RenderSettings settings = settings_of_pipeline();
  for (int way = 0; way < 5; ++way) {
    for (const double fov : {0.05, 0.6, 2.5}) {
      for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode) {
        settings.splat_scale = settings.mode % 2 == 0 ? 1.0f : 0.1f;
        SCOPED_TRACE(testing::Message()
                     << mode_name(settings.mode) << ", way " << way << ", fov " << fov);
        const Camera camera = inside(way, fov);
        test::expect_equal_decisions(gpu->render(camera, settings, test::decisions()),
                                     cpu->render(camera, settings, test::decisions()));
      }
    }
  }
}

TEST_P(CudaOrder, ties_of_depth_are_decided_by_the_file_wherever_its_gaussians_are) {
  // All are at one depth, and neighbours in the file are far apart in space.
  GaussianCloud cloud = test::surrounding_cloud(3000, 0, 5);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double angle = static_cast<double>(i * 7919 % 3000);
    cloud.positions[i] = {0.3 * std::cos(angle), 0.3 * std::sin(angle), 3};
    cloud.log_scales[i] = glm::vec3(i % 3 == 0 ? -1.0f : -3.0f);
    cloud.opacity_logits[i] = 0;
  }
  const auto gpu = renderer_of(Backend::cuda, cloud);
  const Frame& frame =
      gpu->render(test::front_camera(64, 64), settings_of_pipeline(), test::decisions());
  ASSERT_EQ(frame.trace.gaussians.size(), cloud.size());
  ASSERT_GT(frame.stats.max_pairs_in_a_tile, 1000u);
  for (std::size_t tile = 0; tile + 1 < frame.trace.tile_begin.size(); ++tile) {
    const auto begin = frame.trace.listed.begin() + frame.trace.tile_begin[tile];
    const auto end = frame.trace.listed.begin() + frame.trace.tile_begin[tile + 1];
    EXPECT_TRUE(std::is_sorted(begin, end)) << tile;
  }
}

TEST_P(CudaOrder, images_of_a_renderer_do_not_depend_on_the_pipeline_before) {
  const Camera camera = test::front_camera(96, 64);
  const GaussianCloud clouds[] = {test::random_cloud(2000, 2, 6), test::random_cloud(1000, 1, 7)};
  const auto gpu = renderer_of(Backend::cuda, clouds[0]);
  for (const int scene : {0, 1, 0}) {
    SCOPED_TRACE(scene);
    gpu->upload(clouds[scene], {});
    const Image expected =
        renderer_of(Backend::cuda, clouds[scene])->render(camera, settings_of_pipeline()).color;
    for (const Pipeline before : {Pipeline::classic, Pipeline::fast}) {
      RenderSettings other;
      other.pipeline = before;
      gpu->render(camera, other);
      const Frame& frame = gpu->render(camera, settings_of_pipeline());
      EXPECT_EQ(frame.color.values, expected.values);
      EXPECT_EQ(frame.stats.gaussians, clouds[scene].size());
    }
  }
}

/// Rounds coefficients of degree >= 1 to multiples of 2^-8 below 4, which halves equal.
void round_coefficients(GaussianCloud& cloud) {
  const auto each = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  for (std::size_t i = 0; i < cloud.sh.size(); ++i) {
    if (i % each == 0) continue;
    for (int c = 0; c < 3; ++c) {
      cloud.sh[i][c] = std::round(std::clamp(cloud.sh[i][c], -3.9f, 3.9f) * 256) / 256;
    }
  }
}

TEST_P(CudaOrder, coefficients_that_halves_equal_give_the_colours_of_others) {
  const auto draw = [&](const GaussianCloud& cloud) {
    return renderer_of(Backend::cuda, cloud)
        ->render(test::front_camera(80, 60), settings_of_pipeline())
        .color.values;
  };
  for (int degree = 1; degree <= kMaxShDegree; ++degree) {
    SCOPED_TRACE(degree);
    GaussianCloud cloud = test::random_cloud(1000, degree, 8);
    round_coefficients(cloud);
    cloud.opacity_logits.back() = -INFINITY;
    const auto halves = draw(cloud);
    cloud.sh.back().x = 0.1f;  // not a half, so all coefficients are stored in single precision
    EXPECT_EQ(draw(cloud), halves);
  }
}

TEST_P(CudaOrder, a_coefficient_at_the_end_of_a_large_scene_prevents_halves) {
  // Most Gaussians are behind the camera. The last Gaussian in space is by far the largest.
  GaussianCloud cloud = test::random_cloud(70'000, 1, 9);
  round_coefficients(cloud);
  for (std::size_t i = 1000; i < cloud.size(); ++i) cloud.positions[i].z = -10;
  cloud.log_scales[1] = glm::vec3(4);
  cloud.positions[1] = {0, 0, 200};
  cloud.opacity_logits[1] = 0;
  cloud.sh[4 * 1 + 2] = glm::vec3(100.03f);  // halves there are multiples of 1/16
  const Camera camera = test::front_camera(80, 60);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  test::expect_same_image(gpu->render(camera, settings_of_pipeline()).color,
                          cpu->render(camera, settings_of_pipeline()).color);
}

TEST_P(CudaOrder, blocks_of_threads_project_several_blocks_of_a_large_scene) {
  // 4,096 blocks of threads share 20 more blocks of Gaussians. Visible Gaussians are small at the
  // beginning of the order in space, and large at its end; the other Gaussians are beside the view.
  constexpr std::size_t kSome = 20 * 256, kAll = (4096 + 20) * 256;
  std::mt19937 random(10);
  const auto uniform = [&](float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(random);
  };
  GaussianCloud cloud;
  cloud.resize(kAll, 0);
  for (std::size_t i = 0; i < kAll; ++i) {
    const bool is_visible = i % 200 < 2, is_large = i % 200 == 0;
    const float from = is_visible ? -1.0f : 100.0f;
    cloud.positions[i] = {uniform(from, from + 2), uniform(from, from + 2),
                          uniform(from, from + 2) + (is_visible ? 4.0f : 0.0f)};
    cloud.log_scales[i] = glm::vec3(is_large ? -2.0f : -5.0f);
    cloud.rotations[i] = {1, 0, 0, 0};
    cloud.opacity_logits[i] = 1;
    cloud.sh[i] = glm::vec3(0.5f);
  }
  const Camera camera = test::front_camera(96, 96);
  RenderSettings settings = settings_of_pipeline();
  settings.mode = find_culler("exact");
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  const Frame& expected = cpu->render(camera, settings, test::decisions());
  EXPECT_NEAR(double(expected.stats.visible), 2.0 * kSome, 0.2 * kSome);
  test::expect_equal_decisions(gpu->render(camera, settings, test::decisions()), expected);
}

TEST(Half, has_every_value_of_binary16_and_refuses_all_others) {
  // Independent of the bits: +-m 2^e.
  std::uint32_t finite = 0;
  for (std::uint32_t bits = 0; bits < 0x10000; ++bits) {
    const std::uint32_t exponent = bits >> 10 & 31, mantissa = bits & 1023;
    if (exponent == 31) continue;
    ++finite;
    const int scale = exponent == 0 ? -24 : static_cast<int>(exponent) - 25;
    const double magnitude = std::ldexp(exponent == 0 ? mantissa : mantissa + 1024.0, scale);
    const auto value = static_cast<float>(bits < 0x8000 ? magnitude : -magnitude);
    EXPECT_EQ(float_of_half(static_cast<std::uint16_t>(bits)), value);
    std::uint16_t half = 0;
    EXPECT_TRUE(to_half(value, half)) << value;
    EXPECT_EQ(half, bits);
    EXPECT_FALSE(to_half(std::nextafter(value, 1e30f), half)) << value;
    EXPECT_FALSE(to_half(std::nextafter(value, -1e30f), half)) << value;
  }
  EXPECT_EQ(finite, 63'488u);
  std::uint16_t half = 0;
  for (const float value : {65'520.0f, 65'536.0f, 1e30f, INFINITY, -INFINITY, NAN}) {
    EXPECT_FALSE(to_half(value, half)) << value;
  }
}

}  // namespace
}  // namespace qs
