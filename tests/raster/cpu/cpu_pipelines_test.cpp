// SPDX-License-Identifier: MIT
// Pipeline `fast` of the CPU backend against `classic` on every instruction set of this machine:
// tile lists equal to the bit, equal images.
// Not in checked: it takes three minutes there; mode_pairs_test.cpp runs the same code.
#include <array>
#include <cmath>
#include <numeric>

#include <glm/common.hpp>

#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "raster/cpu/fast/survivors.h"
#include "raster/kernel/composite.h"
#include "support/gpu.h"
#include "support/instruction_set.h"
#include "support/mode_pairs.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace qs {
namespace {

class CpuPipeline : public test::InstructionSetTest {
 protected:
  static Outputs everything() {
    Outputs outputs;
    outputs.pairs = outputs.evaluated = outputs.trace = outputs.mode_pairs = true;
    return outputs;
  }

  /// Renders with both pipelines and compares everything.
  static void expect_equal(Renderer& renderer, const Camera& camera, RenderSettings settings) {
    SCOPED_TRACE(testing::Message()
                 << mode_name(settings.mode) << " " << camera.width << "x" << camera.height);
    settings.pipeline = Pipeline::classic;
    const Frame classic = renderer.render(camera, settings, everything());
    settings.pipeline = Pipeline::fast;
    const Frame& fast = renderer.render(camera, settings, everything());
    test::expect_equal_decisions(fast, classic);
    EXPECT_EQ(fast.mode_pairs, classic.mode_pairs);
    test::expect_same_image(fast.color, classic.color);
    // The last bit of a pixel's transmittance may decide at which entry it stops.
    std::size_t different = 0;
    for (std::size_t i = 0; i < classic.evaluated.size(); ++i)
      different += fast.evaluated[i] != classic.evaluated[i];
    EXPECT_LE(different, classic.evaluated.size() / 1000);
  }
};

INSTANTIATE_TEST_SUITE_P(InstructionSets, CpuPipeline, testing::ValuesIn(test::kInstructionSets),
                         [](const auto& set) { return std::string(hwy::TargetName(set.param)); });

TEST_P(CpuPipeline, decide_and_draw_alike_in_every_mode) {
  for (int degree = 0; degree <= kMaxShDegree; ++degree) {
    const GaussianCloud cloud =
        test::random_cloud(3000, degree, 60 + static_cast<unsigned>(degree));
    const auto renderer = make_renderer(Backend::cpu, test::pool(2));
    renderer->upload(cloud, {});
    RenderSettings plain, other;
    other.antialiased = true;
    other.splat_scale = 0.6f;
    other.dilation = 0.02;
    other.sh_degree = 1;
    other.background = {0.2f, 0.4f, 0.9f};
    for (RenderSettings settings : {plain, other}) {
      for (const auto& [width, height] :
           {std::pair{1, 1}, {17, 33}, {96, 64}, {161, 23}, {320, 200}}) {
        for (settings.mode = 1; settings.mode <= mode_count(); ++settings.mode)
          expect_equal(*renderer, test::front_camera(width, height), settings);
      }
    }
  }
}

TEST_P(CpuPipeline, decide_and_draw_alike_in_every_projection) {
  for (const GaussianCloud& cloud :
       {test::random_cloud(3000, 2, 66), test::surrounding_cloud(3000, 1, 67)}) {
    const auto renderer = make_renderer(Backend::cpu, test::pool(2));
    renderer->upload(cloud, {});
    RenderSettings settings;
    for (const Projection projection : test::kOtherProjections) {
      for (const bool antialiased : {false, true}) {
        settings.antialiased = antialiased;
        Camera camera = test::with_projection(test::front_camera(161, 93), projection);
        camera.center_px = {antialiased ? 150.0 : -20.0, 40.0};  // a face that was cut
        for (settings.mode = 1; settings.mode <= mode_count(); ++settings.mode)
          expect_equal(*renderer, camera, settings);
      }
    }
  }
}

TEST_P(CpuPipeline, decide_and_draw_solid_styles_alike_in_every_mode) {
  for (const GaussianCloud& cloud :
       {test::random_cloud(3000, 0, 64), test::surrounding_cloud(3000, 0, 65)}) {
    const auto renderer = make_renderer(Backend::cpu, test::pool(2));
    renderer->upload(cloud, {});
    for (const DrawStyle style : {DrawStyle::points, DrawStyle::ellipsoids}) {
      RenderSettings settings;
      settings.style = style;
      for (const auto& [width, height] : {std::pair{1, 1}, {161, 23}, {320, 200}}) {
        for (settings.mode = 1; settings.mode <= mode_count(); ++settings.mode)
          expect_equal(*renderer, test::front_camera(width, height), settings);
      }
    }
  }
}

TEST_P(CpuPipeline, decide_and_draw_alike_on_the_bundled_scene) {
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(test::read_scene(test::source_path("assets/plush.ply")).cloud, {});
  const auto cameras = read_cameras(test::source_path("assets/cameras.json"));
  for (const char* mode : {"3dgs", "quadbox", "exact"}) {
    RenderSettings settings;
    settings.mode = find_culler(mode);
    expect_equal(*renderer, cameras.front().resized(640, 480), settings);
  }
}

TEST_P(CpuPipeline, decide_and_draw_alike_inside_a_scene_looking_every_way) {
  // These views skip whole blocks, see cpu_blocks_test.cpp.
  GaussianCloud cloud = test::surrounding_cloud(12000, 1, 5);
  test::append(cloud, test::random_cloud(3000, 1, 6));
  for (std::size_t i = 0; i < 5; ++i) cloud.log_scales[i * 2400] += 6.0f;  // seen from all around
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(cloud, {});
  const glm::dvec3 ways[] = {{0, 0, 1},    {0, 0, -1},  {1, 0.2, 0},
                             {-1, 0, 0.3}, {0.1, 1, 0}, {0, -1, 0.1}};
  RenderSettings settings;
  int turn = 0;
  for (const double fov : {0.02, 0.5, 1.5, 2.8}) {
    for (const double distance : {0.0, 1.0, 60.0}) {
      for (const glm::dvec3& way : ways) {
        Camera camera = look_at(-distance * way, way, {0.3, 0.1, 0.9}, fov, 130, 70);
        const double near_depths[] = {0.2, 1e-3, 5.0};
        camera.near_depth = near_depths[turn % 3];
        const float scales[] = {1.0f, 0.1f, 5.0f, 40.0f};
        settings.splat_scale = scales[turn % 4];
        settings.dilation = turn % 5 == 0 ? 0.3 / 16 : 0.3;
        settings.mode = turn % culler_count() + 1;
        settings.antialiased = turn % 2 == 0;
        expect_equal(*renderer, camera, settings);
        ++turn;
      }
    }
  }
}

TEST_P(CpuPipeline, lossless_modes_of_fast_are_equal_bit_for_bit) {
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(test::random_cloud(4000, 1, 77), {});
  const Camera camera = test::front_camera(320, 200);
  RenderSettings settings;
  settings.mode = find_culler("adr");
  const Image adr = renderer->render(camera, settings).color;
  for (const char* name : {"quadbox-naive", "quadbox", "exact"}) {
    settings.mode = find_culler(name);
    EXPECT_EQ(renderer->render(camera, settings).color.values, adr.values) << name;
  }
}

/// Composites every pixel of a frame with kernel/composite.h, which skips nothing by bounds.
Image composited(const Frame& frame, const Camera& camera) {
  Image image(camera.width, camera.height, 3);
  std::vector<std::size_t> slot_of;
  for (std::size_t k = 0; k < frame.trace.gaussians.size(); ++k) {
    slot_of.resize(frame.trace.gaussians[k] + 1);
    slot_of[frame.trace.gaussians[k]] = k;
  }
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto tile = static_cast<std::size_t>(frame.grid.tile_of(x, y));
      float transmittance = 1;
      for (auto i = frame.trace.tile_begin[tile]; i < frame.trace.tile_begin[tile + 1]; ++i) {
        const Splat& splat = frame.trace.splats[slot_of[frame.trace.listed[i]]];
        const float before = transmittance;
        float alpha = 0;
        const Step step =
            composite(splat, static_cast<float>(x), static_cast<float>(y), transmittance, alpha);
        if (step == Step::stops) break;
        for (int c = 0; c < 3 && step == Step::blends; ++c)
          image.at(x, y, c) += alpha * before * splat.color[c];
      }
    }
  }
  return image;
}

TEST_P(CpuPipeline, blend_every_pixel_out_to_the_edge_of_faint_and_thin_gaussians) {
  GaussianCloud cloud = test::random_cloud(3000, 0, 12);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.opacity_logits[i] = -3.0f + static_cast<float>(i % 7) * 0.3f;
    cloud.sh[i] = glm::vec3(4);  // bright, so that single contributions are seen
    if (i % 2 == 0) cloud.log_scales[i] += glm::vec3(1.5f, -2, -3);
  }
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(cloud, {});
  const Camera camera = test::front_camera(320, 200);
  RenderSettings settings;
  for (const Pipeline pipeline : {Pipeline::classic, Pipeline::fast}) {
    settings.pipeline = pipeline;
    const Frame& frame = renderer->render(camera, settings, everything());
    ASSERT_GT(frame.stats.visible, 1000u);
    const Image expected = composited(frame, camera);
    std::size_t different = 0;
    for (std::size_t i = 0; i < expected.values.size(); ++i)
      different += std::abs(frame.color.values[i] - expected.values[i]) > 1e-3f ? 1 : 0;
    // Rounding decides about alphas next to 1/255.
    EXPECT_LE(different, 20u) << kPipelineNames[static_cast<int>(pipeline)];
  }
}

TEST_P(CpuPipeline, alphas_of_one_gaussian_are_exact_to_two_millionths) {
  // White on black, so that a pixel's colour is its alpha.
  const Camera camera = test::front_camera(320, 200);
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  for (const float logit : {-5.0f, 0.0f, 4.0f, 6.0f}) {
    GaussianCloud cloud = test::single_gaussian({0.1f, -0.05f, 3}, 0.02f, {1, 1, 1}, logit);
    cloud.log_scales[0] = {-3, -5, -5};
    cloud.rotations[0] = glm::angleAxis(0.6f, glm::vec3(0, 0, 1));
    renderer->upload(cloud, {});
    RenderSettings settings;
    settings.pipeline = Pipeline::fast;
    const Image alphas = renderer->render(camera, settings).color;
    settings.mode = kReferenceMode;
    const Image expected = renderer->render(camera, settings).color;
    EXPECT_EQ(test::share_beyond(alphas, expected, 2e-6), 0) << logit;
  }
}

TEST_P(CpuPipeline, results_do_not_depend_on_threads_or_on_earlier_frames) {
  const GaussianCloud cloud = test::random_cloud(9000, 1, 8);
  const Camera camera = test::front_camera(200, 150);
  const auto one = make_renderer(Backend::cpu, test::pool(1));
  one->upload(cloud, {});
  const Frame expected = one->render(camera, {}, everything());
  for (const int threads : {2, 3, 8}) {
    const auto many = make_renderer(Backend::cpu, test::pool(threads));
    many->upload(cloud, {});
    for (int frame = 0; frame < 2; ++frame) {
      const Frame& got = many->render(camera, {}, everything());
      EXPECT_EQ(got.color.values, expected.color.values) << threads;
      EXPECT_EQ(got.evaluated, expected.evaluated) << threads;
      EXPECT_EQ(test::difference(got.trace, expected.trace), "") << threads;
      many->render(test::front_camera(50, 20));  // another size in between
    }
  }
}

TEST_P(CpuPipeline, coefficients_kept_in_half_precision_draw_what_all_of_them_draw) {
  GaussianCloud cloud = test::random_cloud(3000, 3, 91);
  for (glm::vec3& value : cloud.sh) value = glm::round(value * 128.0f) / 128.0f;  // as in .spz
  ThreadPool pool(2);
  const auto harmonics_of = [&pool](const GaussianCloud& some) {
    std::vector<std::uint32_t> order(some.size());
    std::iota(order.begin(), order.end(), 0u);
    return cpu::fast::make_harmonics(some, order, pool);
  };
  EXPECT_TRUE(harmonics_of(cloud).rest.empty());
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(cloud, {});
  const Camera camera = test::front_camera(161, 97);
  expect_equal(*renderer, camera, {});
  const Image halves = renderer->render(camera).color;
  // A Gaussian behind the camera with one coefficient that is not a half.
  test::append(cloud, [] {
    GaussianCloud hidden = test::random_cloud(1, 3, 1);
    hidden.positions[0] = {0, 0, -5};
    hidden.sh[7].x = 0.1f;
    return hidden;
  }());
  EXPECT_FALSE(harmonics_of(cloud).rest.empty());
  renderer->upload(cloud, {});
  EXPECT_EQ(renderer->render(camera).color.values, halves.values);
}

TEST_P(CpuPipeline, half_precision_holds_a_value_exactly_or_not_at_all) {
  const auto converted = [](float value, std::uint16_t& bits) {
    std::array<float, 16> values{};
    std::array<std::uint16_t, 16> halves{};
    values[11] = value;
    const bool exact = cpu::fast::to_halves(values.data(), values.size(), halves.data());
    bits = halves[11];
    return exact;
  };
  std::uint16_t got = 0;
  const std::pair<float, int> held[] = {{0.0f, 0x0000},     {-0.0f, 0x0000},
                                        {1.0f, 0x3c00},     {-127.0f / 128, 0xbbf0},
                                        {65504.0f, 0x7bff}, {std::ldexp(1.0f, -14), 0x0400},
                                        {-65504.0f, 0xfbff}};
  for (const auto& [value, bits] : held) {
    EXPECT_TRUE(converted(value, got)) << value;
    EXPECT_EQ(value == 0 ? got & 0x7fff : got, bits) << value;
  }
  for (const float value : {0.1f, 65520.0f, 65536.0f, std::ldexp(1.0f, -25), 1.0f + 1.0f / 2048,
                            INFINITY, -INFINITY, NAN})
    EXPECT_FALSE(converted(value, got)) << value;
  // Some instruction sets lack subnormal halves.
  EXPECT_TRUE(!converted(std::ldexp(1.0f, -15), got) || got == 0x0200);
}

/// Compares the tile lists of both pipelines. Returns the number of visible Gaussians.
std::uint32_t expect_equal_lists(const GaussianCloud& cloud) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(3));
  renderer->upload(cloud, {});
  Outputs outputs;
  outputs.trace = true;
  RenderSettings settings;
  settings.pipeline = Pipeline::classic;
  const Camera camera = test::front_camera(64, 64);
  const Frame classic = renderer->render(camera, settings, outputs);
  settings.pipeline = Pipeline::fast;
  const Frame& fast = renderer->render(camera, settings, outputs);
  EXPECT_EQ(test::difference(fast.trace, classic.trace), "");
  return classic.stats.visible;
}

TEST(CpuPipelineSort, depths_far_apart_and_equal_are_sorted_alike) {
  // 40 octaves of depth, every depth five times: all digits of the sort, and ties.
  GaussianCloud cloud;
  for (int i = 0; i < 400; ++i) {
    const float z = std::exp2(static_cast<float>((i * 7919) % 80) * 0.5f - 2.0f);
    test::append(cloud, test::single_gaussian({0, 0, z}, z * 0.05f, {0.5f, 0.2f, 0.1f}, -3.0f));
  }
  EXPECT_GT(expect_equal_lists(cloud), 300u);
}

TEST(CpuPipelineSort, equal_depths_keep_the_order_of_the_file_wherever_they_lie) {
  // Planes of equal depth with Gaussians in random order, so that a run spans several threads.
  GaussianCloud cloud = test::random_cloud(60000, 0, 3);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    glm::vec3& p = cloud.positions[i];
    const float z = i % 4 == 0 ? 2.0f + static_cast<float>(i % 3) : 3.0f;
    p = {p.x / std::abs(p.z) * z, p.y / std::abs(p.z) * z, z};
  }
  EXPECT_GT(expect_equal_lists(cloud), 30000u);
}

}  // namespace
}  // namespace qs
