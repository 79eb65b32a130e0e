// SPDX-License-Identifier: MIT
// Frames of the CPU backend against an oracle that shares no code with it.
// Not in checked: the oracle takes long there; depth_test.cpp runs the same code.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "raster/api/renderer.h"
#include "support/oracle.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

Frame render(const GaussianCloud& cloud, const Camera& camera, const RenderSettings& settings,
             const Outputs& outputs = {}, int threads = 2) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(threads));
  renderer->upload(cloud, {});
  return renderer->render(camera, settings, outputs);
}

RenderSettings with_mode(const char* name) {
  RenderSettings settings;
  settings.mode = find_culler(name);
  return settings;
}

test::OracleSettings rules_of(const GaussianCloud& cloud, const RenderSettings& settings) {
  test::OracleSettings rules;
  rules.background = settings.background;
  rules.sh_degree = settings.sh_degree;
  rules.splat_scale = static_cast<double>(settings.splat_scale);
  rules.dilation = settings.dilation;
  rules.antialiased = settings.antialiased.value_or(cloud.antialiased);
  return rules;
}

Image oracle_of(const GaussianCloud& cloud, const Camera& camera, const RenderSettings& settings) {
  return test::oracle_image(cloud, camera, rules_of(cloud, settings));
}

/// The expected image. In a mode that is not lossless a Gaussian contributes only to the tiles that
/// list it, which are read from the frame's trace.
Image expected_image(const GaussianCloud& cloud, const Camera& camera,
                     const RenderSettings& settings, const Frame& frame) {
  if (row_of(settings.mode).lossless) return oracle_of(cloud, camera, settings);
  std::vector<std::vector<bool>> listed(cloud.size());
  const auto tiles = static_cast<std::size_t>(frame.grid.count());
  for (auto& gaussian : listed) gaussian.resize(tiles);
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    for (auto k = frame.trace.tile_begin[tile]; k < frame.trace.tile_begin[tile + 1]; ++k) {
      listed[frame.trace.listed[k]][tile] = true;
    }
  }
  test::OracleSettings rules = rules_of(cloud, settings);
  rules.acts = [&](std::size_t i, int x, int y) {
    return static_cast<bool>(
        listed[i][static_cast<std::size_t>(y / kTileSize * frame.grid.columns + x / kTileSize)]);
  };
  return test::oracle_image(cloud, camera, rules);
}

double largest_difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.values.size(), b.values.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    largest = std::max(
        largest, std::abs(static_cast<double>(a.values[i]) - static_cast<double>(b.values[i])));
  }
  return largest;
}

class EveryMode : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Cullers, EveryMode, testing::Range(0, culler_count() + 1),
                         [](const auto& mode) {
                           std::string name = mode_name(mode.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(EveryMode, draws_the_image_that_its_rules_say) {
  const GaussianCloud cloud = test::random_cloud(1500, 3, 42);
  RenderSettings settings;
  settings.mode = GetParam();
  Outputs outputs;
  outputs.trace = true;
  for (const auto& [width, height] : {std::pair{96, 64}, {50, 71}, {1, 1}, {161, 23}}) {
    const Camera camera = test::front_camera(width, height);
    const Frame frame = render(cloud, camera, settings, outputs);
    const Image expected = expected_image(cloud, camera, settings, frame);
    EXPECT_GE(psnr_8bit(frame.color, expected), 80.0) << width << "x" << height;
    EXPECT_LT(largest_difference(frame.color, expected), 1.5 / 255) << width << "x" << height;
  }
}

TEST_P(EveryMode, honours_background_degree_scale_dilation_and_antialiasing) {
  const GaussianCloud cloud = test::random_cloud(300, 2, 9);
  const Camera camera = test::front_camera(64, 48);
  RenderSettings settings;
  settings.mode = GetParam();
  settings.background = {0.2f, 0.4f, 0.9f};
  settings.sh_degree = 1;
  settings.splat_scale = 0.6f;
  settings.dilation = 0.05;
  settings.antialiased = true;
  Outputs outputs;
  outputs.trace = true;
  const Frame frame = render(cloud, camera, settings, outputs);
  EXPECT_GE(psnr_8bit(frame.color, expected_image(cloud, camera, settings, frame)), 80.0);
}

TEST_P(EveryMode, draws_the_background_for_an_empty_scene) {
  RenderSettings settings;
  settings.mode = GetParam();
  settings.background = {0.25f, 0.5f, 0.75f};
  const Frame frame = render({}, test::front_camera(33, 17), settings);
  EXPECT_EQ(frame.color.at(32, 16, 0), 0.25f);
  EXPECT_EQ(frame.color.at(0, 0, 2), 0.75f);
  EXPECT_EQ(frame.stats.visible, 0u);
}

TEST(Images, lossless_modes_are_equal_bit_for_bit) {
  const GaussianCloud cloud = test::random_cloud(4000, 1, 77);
  const Camera camera = test::front_camera(320, 200);
  const Frame adr = render(cloud, camera, with_mode("adr"));
  for (const char* name : {"quadbox-naive", "quadbox", "exact"}) {
    const Frame frame = render(cloud, camera, with_mode(name));
    EXPECT_EQ(frame.color.values, adr.color.values) << name;
    EXPECT_LE(frame.stats.tile_pairs, adr.stats.tile_pairs) << name;
  }
}

TEST(Images, the_reference_equals_trying_every_gaussian_on_every_pixel) {
  const GaussianCloud cloud = test::random_cloud(5000, 3, 5);
  const Camera camera = test::front_camera(64, 48);
  const Frame frame = render(cloud, camera, with_mode("reference"));
  EXPECT_LT(largest_difference(frame.color, oracle_of(cloud, camera, {})),
            2e-6);  // two orders of summing in double
}

TEST(Images, do_not_depend_on_the_number_of_threads) {
  const GaussianCloud cloud = test::random_cloud(6000, 2, 8);
  const Camera camera = test::front_camera(200, 150);
  Outputs outputs;
  outputs.pairs = outputs.evaluated = outputs.trace = true;
  const Frame one = render(cloud, camera, with_mode("quadbox"), outputs, 1);
  for (const int threads : {2, 3, 8}) {
    const Frame many = render(cloud, camera, with_mode("quadbox"), outputs, threads);
    EXPECT_EQ(many.color.values, one.color.values);
    EXPECT_EQ(many.trace.listed, one.trace.listed);
    EXPECT_EQ(many.evaluated, one.evaluated);
  }
}

TEST(Images, tile_lists_are_front_to_back_with_ties_by_index) {
  const GaussianCloud cloud = test::random_cloud(3000, 0, 21);
  Outputs outputs;
  outputs.trace = outputs.pairs = true;
  for (int mode = 1; mode <= culler_count(); ++mode) {
    RenderSettings settings;
    settings.mode = mode;
    const Frame frame = render(cloud, test::front_camera(128, 96), settings, outputs);
    std::vector<float> depth_of(cloud.size());
    for (std::size_t k = 0; k < frame.trace.gaussians.size(); ++k) {
      depth_of[frame.trace.gaussians[k]] = frame.trace.depths[k];
    }
    std::uint64_t total = 0;
    for (std::size_t tile = 0; tile < frame.pairs.size(); ++tile) {
      const auto begin = frame.trace.tile_begin[tile], end = frame.trace.tile_begin[tile + 1];
      EXPECT_EQ(end - begin, frame.pairs[tile]);
      total += frame.pairs[tile];
      for (auto k = begin + 1; k < end; ++k) {
        const auto a = frame.trace.listed[k - 1], b = frame.trace.listed[k];
        EXPECT_TRUE(depth_of[a] < depth_of[b] || (depth_of[a] == depth_of[b] && a < b));
      }
    }
    EXPECT_EQ(total, frame.stats.tile_pairs);
    EXPECT_EQ(frame.stats.max_pairs_in_a_tile,
              *std::max_element(frame.pairs.begin(), frame.pairs.end()));
  }
}

TEST(Images, a_pixel_stops_before_the_gaussian_that_would_make_it_opaque) {
  // Two opaque Gaussians would leave T = (1 - 0.99)^2 = 1e-4, which fp32 may round up or down. With
  // a Gaussian of half opacity between them the result is clear.
  GaussianCloud cloud = test::single_gaussian({0, 0, 2}, 1.0f, {1, 0, 0}, INFINITY);
  test::append(cloud, test::single_gaussian({0, 0, 3}, 1.0f, {0, 1, 0}, 0.0f));
  test::append(cloud, test::single_gaussian({0, 0, 4}, 1.0f, {0, 0, 1}, INFINITY));
  Outputs outputs;
  outputs.evaluated = true;
  RenderSettings settings = with_mode("quadbox");
  settings.background = {0, 0, 1};
  const Frame frame = render(cloud, test::front_camera(33, 33), settings, outputs);
  // T after two: 0.01 * 0.5 = 5e-3; the third would leave 5e-5 < 1e-4, so it is skipped and T kept.
  EXPECT_NEAR(frame.color.at(16, 16, 0), 0.99f, 1e-4);
  EXPECT_NEAR(frame.color.at(16, 16, 1), 0.005f, 1e-4);
  EXPECT_NEAR(frame.color.at(16, 16, 2), 0.005f, 1e-4)
      << "the background gets the kept transmittance";
  EXPECT_EQ(frame.evaluated[16 * 33 + 16], 3u) << "the entry at which it stopped counts";
}

TEST(Images, hidden_gaussians_do_not_change_the_image) {
  GaussianCloud cloud;
  for (int layer = 0; layer < 4; ++layer) {
    test::append(cloud, test::single_gaussian({0, 0, 2.0f + 0.1f * static_cast<float>(layer)}, 5.0f,
                                              {0.3f, 0.6f, 0.1f}, INFINITY));
  }
  const Camera camera = test::front_camera(48, 48);
  const Frame before = render(cloud, camera, with_mode("quadbox"));
  GaussianCloud behind = test::random_cloud(500, 0, 2);
  for (glm::vec3& position : behind.positions) position.z = std::abs(position.z) + 10;
  test::append(cloud, behind);
  EXPECT_EQ(render(cloud, camera, with_mode("quadbox")).color.values, before.color.values);
}

TEST(Images, a_cancelled_frame_throws_and_the_next_one_is_right) {
  const GaussianCloud cloud = test::random_cloud(2000, 0, 4);
  const Camera camera = test::front_camera(64, 64);
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(cloud, {});
  std::stop_source source;
  source.request_stop();
  for (int mode = 0; mode <= culler_count(); ++mode) {
    RenderSettings settings;
    settings.mode = mode;
    EXPECT_THROW(renderer->render(camera, settings, {}, HostImage{}, source.get_token()),
                 Cancelled);
    EXPECT_EQ(renderer->render(camera, settings).color.values,
              render(cloud, camera, settings).color.values);
  }
}

TEST(Images, a_frame_reports_how_much_of_it_is_done) {
  const GaussianCloud cloud = test::random_cloud(300, 0, 4);
  const Camera camera = test::front_camera(256, 256);
  const auto renderer = make_renderer(Backend::cpu, test::pool(1));
  renderer->upload(cloud, {});
  std::vector<float> seen;
  renderer->report_frames_to([&](float fraction) { seen.push_back(fraction); });
  for (const CullMode mode : {kReferenceMode, default_mode()}) {
    for (const Pipeline pipeline : {Pipeline::fast, Pipeline::classic}) {
      seen.clear();
      RenderSettings settings;
      settings.mode = mode;
      settings.pipeline = pipeline;
      renderer->render(camera, settings);
      EXPECT_GT(seen.size(), 20u);
      EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
      EXPECT_EQ(seen.front(), 0);
      EXPECT_GT(seen.back(), 0.9f);
      EXPECT_LT(seen.back(), 1);
    }
  }
  renderer->report_frames_to({});
  seen.clear();
  renderer->render(camera, {});
  EXPECT_TRUE(seen.empty());
}

TEST(Images, eight_bit_output_rounds_half_up_and_clamps) {
  EXPECT_EQ(to_8bit(0.5f / 255), 1);
  EXPECT_EQ(to_8bit(0.499f / 255), 0);
  EXPECT_EQ(to_8bit(1.7f), 255);
  EXPECT_EQ(to_8bit(-3.0f), 0);
  EXPECT_EQ(to_8bit(NAN), 0);
}

}  // namespace
}  // namespace qs
