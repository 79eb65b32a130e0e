// SPDX-License-Identifier: MIT
//
// What benchmarks compute from measured numbers, and the paths their cameras take.
#include <algorithm>
#include <array>
#include <fstream>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/measure/camera_path.h"
#include "app/measure/measure_view.h"
#include "app/measure/noise.h"
#include "app/measure/replicate.h"
#include "app/measure/shard.h"
#include "app/measure/statistics.h"
#include "app/measure/zoom_path.h"
#include "app/report/markdown.h"
#include "app/report/zoom_bundle.h"
#include "app/session/camera_control.h"
#include "io/camera/cameras.h"
#include "raster/base/error.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::HasSubstr;

BenchRow row(const std::string& mode, double ms, std::uint64_t pairs, std::uint64_t view = 0) {
  BenchRow result;
  result.scene = "tiny";
  result.camera = std::to_string(view);
  result.mode = mode;
  result.backend = "cpu";
  result.gaussians = 1000;
  result.pairs = pairs;
  result.ms_median = result.ms_p05 = result.ms_p95 = ms;
  result.view = view;
  return result;
}

BenchReport report(std::vector<BenchRow> rows) {
  return {{{"cpu", "some CPU"}, {"backend", "cpu"}, {"commit", "abc"}},
          nlohmann::ordered_json::array(),
          rows.size(),
          std::move(rows)};
}

TEST(Statistics, median_and_percentiles_interpolate_between_sorted_values) {
  const std::array<double, 4> values = {4, 1, 3, 2};
  EXPECT_DOUBLE_EQ(median(values), 2.5);
  EXPECT_DOUBLE_EQ(percentile(values, 0), 1);
  EXPECT_DOUBLE_EQ(percentile(values, 1), 4);
  EXPECT_DOUBLE_EQ(percentile(values, 0.05), 1.15);
  EXPECT_DOUBLE_EQ(summarise(values).mean, 2.5);
}

TEST(Statistics, drift_compares_the_later_half_with_the_earlier_half) {
  EXPECT_DOUBLE_EQ(summarise(std::array{2.0, 2.0, 3.0, 3.0}).drift, 0.5);
  EXPECT_DOUBLE_EQ(summarise(std::array{2.0, 9.0, 2.0}).drift, 0);
  EXPECT_DOUBLE_EQ(summarise(std::array{7.0}).drift, 0);
  EXPECT_DOUBLE_EQ(relative_spread(std::array{10.0, 10.5, 9.5}), 0.1);
}

TEST(BenchReport, csv_has_the_documented_columns_and_one_line_per_row) {
  const std::string csv = format_csv({row("3dgs", 2, 10), row("quadbox", 1, 5)});
  EXPECT_EQ(csv.substr(0, csv.find('\n')),
            "scene,camera,mode,pipeline,backend,width,height,gaussians,visible,pairs,"
            "pairs_per_visible,max_tile,ms_median,ms_p05,ms_p95,fps_median,frame_ms,preprocess_ms,"
            "bin_ms,sort_ms,blend_ms,psnr_vs_reference,false_positives,false_positive_share");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_THAT(csv, HasSubstr("\ntiny,0,quadbox,classic,cpu,"));
}

TEST(BenchReport, markdown_tells_speed_up_and_sort_bytes) {
  const std::string text = format_markdown(report({row("3dgs", 2, 1000), row("quadbox", 1, 400)}));
  EXPECT_THAT(text, HasSubstr("| `quadbox` | 1,000 | - | 1.000 | 1000.0 | 2.00x | 400 | 4.8 kB |"));
}

// Says that its frames took the times of a list, one after another.
class ScriptedRenderer : public Renderer {
 public:
  explicit ScriptedRenderer(std::vector<float> times_ms) : times_ms_(std::move(times_ms)) {}
  void upload(const GaussianCloud&, const Progress&) override {}
  void submit(const Camera&, const RenderSettings&, const Outputs&, const Target&,
              std::stop_token) override {
    frame_.stats.frame_ms = times_ms_[next_++ % times_ms_.size()];
  }
  const Frame& wait() override { return frame_; }

 private:
  std::vector<float> times_ms_;
  std::size_t next_ = 0;
  Frame frame_;
};

// The row of a view that was measured in three rounds of two frames, which take these times.
BenchRow three_rounds(std::vector<float> times_ms) {
  Session session;
  session.renderer = std::make_unique<ScriptedRenderer>(std::move(times_ms));
  return measure_view(session, {kDefaultMode}, test::front_camera(64, 48), {2, 0, 3}, {}).front();
}

TEST(Noise, rounds_whose_medians_differ_by_more_than_three_per_cent_are_told) {
  const BenchRow calm = three_rounds({2.00f, 2.00f, 2.02f, 2.02f, 2.00f, 2.00f});
  EXPECT_NEAR(calm.round_spread, 0.01, 1e-6);
  EXPECT_EQ(noise_sentence({calm}), "");
  const BenchRow restless = three_rounds({2.0f, 2.0f, 1.9f, 1.9f, 2.0f, 2.0f});
  EXPECT_NEAR(restless.round_spread, 0.05, 1e-6);
  EXPECT_THAT(noise_sentence({restless}), HasSubstr("rounds differ by 5.0 %"));
}

TEST(Noise, is_told_in_one_sentence_that_names_the_worst_row) {
  std::vector<BenchRow> rows = {row("3dgs", 1, 1, 0), row("adr", 1, 1, 1), row("exact", 1, 1, 2)};
  rows[0].drift = 0.02;
  EXPECT_EQ(noise_sentence(rows), "");
  EXPECT_EQ(noise_markdown(rows), "");
  rows[0].drift = 0.04;
  rows[1].drift = -0.08;
  rows[2].round_spread = 0.05;
  EXPECT_THAT(noise_sentence(rows), testing::StartsWith("3 of 3 rows are noisy, beyond 3 %: the "
                                                        "worst is tiny, camera 1, adr: its later "
                                                        "frames took -8.0 %"));
  EXPECT_EQ(noise_sentence(rows).find('\n'), std::string::npos);
  EXPECT_THAT(noise_markdown(rows), HasSubstr("| tiny | 2 | `exact` | +0.0 % | 5.0 % |"));
}

TEST(Shard, every_view_belongs_to_exactly_one_shard) {
  for (std::size_t view = 0; view < 20; ++view) {
    int takers = 0;
    for (const char* text : {"1/3", "2/3", "3/3"})
      takers += parse_shard("--shard", text).takes(view) ? 1 : 0;
    EXPECT_EQ(takers, 1);
  }
  for (const char* text : {"0/3", "4/3", "3", "a/b", "1/0"})
    EXPECT_THROW(parse_shard("--shard", text), Error) << text;
}

TEST(ZoomPath, distances_shrink_by_one_ratio_and_end_where_asked) {
  const Camera start = test::front_camera(64, 48);
  const glm::dvec3 target(0.5, -0.25, 4);
  const std::vector<Camera> path = zoom_path(start, target, 9, 0.05);
  ASSERT_EQ(path.size(), 9u);
  const auto distance = [&](std::size_t i) { return glm::length(path[i].position() - target); };
  EXPECT_EQ(path[0].view_from_world, start.view_from_world);
  for (std::size_t i = 2; i < path.size(); ++i)
    EXPECT_NEAR(distance(i) / distance(i - 1), distance(1) / distance(0), 1e-9);
  EXPECT_NEAR(distance(8), 0.05 * distance(0), 1e-9);
}

TEST(ZoomPath, the_target_is_the_opaque_gaussian_under_the_centre_for_every_tile_size) {
  const auto renderer = make_renderer(Backend::cpu);
  renderer->upload(test::single_gaussian({0, 0, 3}, 0.2f, {1, 1, 1}, 8), {});
  const Camera camera = test::front_camera(96, 80);
  for (const int tile_px : kTileSizes) {
    SCOPED_TRACE(tile_px);
    RenderSettings settings;
    settings.tile_px = tile_px;
    const auto point = find_point(*renderer, camera, settings, {48, 40});
    ASSERT_TRUE(point.has_value());
    EXPECT_NEAR(point->z, 3, 1e-5);
    EXPECT_EQ(find_point(*renderer, camera, settings, {0, 0}), std::nullopt);
    EXPECT_EQ(find_point(*renderer, camera, settings, {96, 40}), std::nullopt);
  }
}

TEST(ZoomPath, the_centre_pixel_is_right_of_and_below_the_middle) {
  EXPECT_EQ(center_pixel(test::front_camera(64, 48)), glm::ivec2(32, 24));
  EXPECT_EQ(center_pixel(test::front_camera(7, 5)), glm::ivec2(3, 2));
}

TEST(ZoomBundle, is_read_back_as_written_and_a_changed_count_is_told) {
  const TemporaryFolder folder;
  ZoomBundle bundle;
  bundle.scene = "scene.ply";
  bundle.start = test::front_camera(64, 48);
  bundle.target = {0.1, 1.0 / 3, -2};
  bundle.modes = {1, 5};
  bundle.environment = nlohmann::ordered_json::object();
  bundle.rows = {row("3dgs", 1, 5), row("quadbox", 1, 4)};
  std::ofstream(folder / "zoom.json") << format_zoom_json(bundle);
  const ZoomBundle read = read_zoom_json(folder / "zoom.json");
  EXPECT_EQ(format_zoom_json(read), format_zoom_json(bundle));
  EXPECT_TRUE(count_differences(bundle.rows, read.rows).empty());
  std::vector<BenchRow> changed = bundle.rows;
  changed[1].pairs += 1;
  EXPECT_EQ(count_differences(bundle.rows, changed).size(), 1u);
}

TEST(CameraPath, passes_through_its_keyframes) {
  std::vector<Keyframe> keyframes;
  for (int i = 0; i < 5; ++i) {
    const glm::dvec3 position(i, 0.3 * i * i, -3 + 0.2 * i);
    keyframes.push_back(
        {i * (i + 1) / 2.0, look_at(position, {0, 0, 2}, {0, -1, 0}, 0.9 - 0.1 * i, 64, 48)});
  }
  for (const Keyframe& key : keyframes) {
    const Camera camera = camera_at(keyframes, key.time);
    EXPECT_LT(glm::length(camera.position() - key.camera.position()), 1e-9);
    EXPECT_NEAR(camera.focal_px.y, key.camera.focal_px.y, 1e-9);
    for (int column = 0; column < 3; ++column) {
      EXPECT_LT(glm::length(camera.view_from_world[column] - key.camera.view_from_world[column]),
                1e-9);
    }
  }
  EXPECT_EQ(sample_path(keyframes, 7).size(), 7u);
}

TEST(Replicate, copies_keep_their_distance_and_the_first_stays) {
  const GaussianCloud cloud = test::random_cloud(100, 1, 5);
  const GaussianCloud grid = replicate(cloud, {3, 2}, {0, -1, 0});
  ASSERT_EQ(grid.size(), 600u);
  EXPECT_EQ(grid.positions[7], cloud.positions[7]);
  for (std::size_t copy = 1; copy < 6; ++copy) {
    const glm::vec3 offset = grid.positions[copy * 100] - cloud.positions[0];
    EXPECT_EQ(offset.y, 0);
    EXPECT_GT(glm::length(offset), 0);
    EXPECT_EQ(grid.sh[copy * 400 + 13], cloud.sh[13]);
  }
}

}  // namespace
}  // namespace qs
