// SPDX-License-Identifier: MIT
// Used pairs of the CPU backend: pairs that at least one pixel blends.
// Not in checked: large scenes take long there; depth_test.cpp runs the same code.
#include <gtest/gtest.h>

#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "raster/api/renderer.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace qs {
namespace {

const CullMode kLossless[] = {find_culler("adr"), find_culler("quadbox-naive"),
                              find_culler("quadbox"), find_culler("exact")};

Frame render(const GaussianCloud& cloud, const Camera& camera, CullMode mode, bool color = true) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(cloud, {});
  RenderSettings settings;
  settings.mode = mode;
  Outputs outputs;
  outputs.color = color;
  outputs.pairs = outputs.used = outputs.trace = true;
  return renderer->render(camera, settings, outputs);
}

/// The definition in double precision, computed from the trace.
std::uint32_t used_by_definition(const Frame& frame, const Camera& camera, int tile) {
  const Trace& trace = frame.trace;
  std::vector<std::size_t> slot_of(frame.stats.gaussians);
  for (std::size_t slot = 0; slot < trace.gaussians.size(); ++slot)
    slot_of[trace.gaussians[slot]] = slot;
  const std::uint64_t begin = trace.tile_begin[static_cast<std::size_t>(tile)];
  const std::uint64_t end = trace.tile_begin[static_cast<std::size_t>(tile) + 1];
  std::vector<bool> used(end - begin);
  const int x0 = tile % frame.grid.columns * kTileSize, y0 = tile / frame.grid.columns * kTileSize;
  for (int y = y0; y < std::min(y0 + kTileSize, camera.height); ++y) {
    for (int x = x0; x < std::min(x0 + kTileSize, camera.width); ++x) {
      double transmittance = 1;
      for (std::uint64_t k = begin; k < end; ++k) {
        const std::size_t slot = slot_of[trace.listed[k]];
        const glm::dvec3 conic(trace.footprints[slot].conic);
        const glm::dvec2 d = glm::dvec2(x, y) - glm::dvec2(trace.footprints[slot].mean_px);
        const double q = conic.x * d.x * d.x + 2 * conic.y * d.x * d.y + conic.z * d.y * d.y;
        const double opacity = static_cast<double>(trace.splats[slot].opacity);
        const double alpha = std::min(0.99, opacity * std::exp(-0.5 * q));
        if (q < 0 || alpha < 1.0 / 255) continue;
        if (transmittance * (1 - alpha) < 1e-4) break;
        transmittance *= 1 - alpha;
        used[k - begin] = true;
      }
    }
  }
  return static_cast<std::uint32_t>(std::count(used.begin(), used.end(), true));
}

TEST(UsedPairs, are_the_listed_ones_that_a_pixel_of_the_tile_blends) {
  const GaussianCloud cloud = test::random_cloud(4000, 0, 7);
  const Camera camera = test::front_camera(133, 97);  // ends within a tile
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const Frame frame = render(cloud, camera, mode);
    ASSERT_EQ(frame.used.size(), static_cast<std::size_t>(frame.grid.count()));
    int different = 0;
    for (int tile = 0; tile < frame.grid.count(); ++tile) {
      const std::uint32_t expected = used_by_definition(frame, camera, tile);
      different += std::abs(static_cast<int>(frame.used[static_cast<std::size_t>(tile)]) -
                            static_cast<int>(expected));
    }
    // An alpha next to 1/255 may fall on either side.
    EXPECT_LE(different, static_cast<int>(frame.stats.tile_pairs / 10000) + 1);
  }
}

TEST(UsedPairs, are_the_same_in_every_lossless_mode_so_that_shorter_lists_waste_less) {
  const GaussianCloud cloud = test::random_cloud(4000, 0, 8);
  const Camera camera = test::front_camera(320, 200);
  const Frame adr = render(cloud, camera, kLossless[0]);
  for (const CullMode mode : kLossless)
    EXPECT_EQ(render(cloud, camera, mode).used, adr.used) << mode_name(mode);
}

TEST(UsedPairs, sum_up_in_the_statistics_and_are_at_most_the_listed_ones) {
  const Camera camera = test::front_camera(100, 80);
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const Frame frame = render(test::random_cloud(3000, 0, 9), camera, mode);
    EXPECT_EQ(frame.stats.used_pairs, sum_of(frame.used));
    EXPECT_GT(*frame.stats.used_pairs, 0u);
    EXPECT_LT(*frame.stats.used_pairs, frame.stats.tile_pairs);
    for (std::size_t tile = 0; tile < frame.used.size(); ++tile)
      EXPECT_LE(frame.used[tile], frame.pairs[tile]);
  }
}

TEST(UsedPairs, leave_exact_the_fewest_false_positives_on_a_trained_scene) {
  QS_NEEDS_SHARED("scenes/plush.spz");
  const GaussianCloud cloud = test::read_scene(test::shared_path("scenes/plush.spz")).cloud;
  const Camera camera = read_cameras(test::shared_path("scenes/plush/cameras.json")).front();
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(cloud, {});
  Outputs outputs;
  outputs.color = false;
  outputs.used = true;
  std::vector<std::uint64_t> wasted;
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    RenderSettings settings;
    settings.mode = mode;
    const RenderStats& stats = renderer->render(camera, settings, outputs).stats;
    wasted.push_back(stats.tile_pairs - *stats.used_pairs);
  }
  const std::size_t exact = static_cast<std::size_t>(find_culler("exact")) - 1;
  for (std::size_t i = 0; i < wasted.size(); ++i)
    EXPECT_TRUE(i == exact || wasted[exact] < wasted[i])
        << row_of(static_cast<CullMode>(i + 1)).name;
}

TEST(UsedPairs, of_a_gaussian_behind_an_opaque_wall_are_none) {
  const Camera camera = test::front_camera(64, 64);
  GaussianCloud cloud;
  cloud.resize(0, 0);
  for (int layer = 0; layer < 4; ++layer)  // 0.01^2 is the last transmittance above 1e-4
    test::append(cloud, test::single_gaussian({0, 0, 1 + 0.01f * static_cast<float>(layer)}, 100,
                                              {1, 0, 0}, 20));
  const Frame wall = render(cloud, camera, default_mode());
  test::append(cloud, test::single_gaussian({0, 0, 3}, 0.05f, {0, 1, 0}, 20));
  const Frame with_hidden = render(cloud, camera, default_mode());
  EXPECT_GT(with_hidden.stats.tile_pairs, wall.stats.tile_pairs);
  EXPECT_EQ(with_hidden.used, wall.used);
}

TEST(UsedPairs, are_counted_without_an_image_and_only_when_asked_for) {
  const GaussianCloud cloud = test::random_cloud(2000, 0, 10);
  const Camera camera = test::front_camera(90, 60);
  const Frame with_color = render(cloud, camera, default_mode());
  const Frame without = render(cloud, camera, default_mode(), false);
  EXPECT_TRUE(without.color.values.empty());
  EXPECT_EQ(without.used, with_color.used);
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(cloud, {});
  const Frame plain = renderer->render(camera);
  EXPECT_EQ(plain.color.values, with_color.color.values);
  EXPECT_TRUE(plain.used.empty());
  EXPECT_FALSE(plain.stats.used_pairs.has_value());
}

}  // namespace
}  // namespace qs
