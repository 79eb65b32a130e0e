// SPDX-License-Identifier: MIT
//
// The numbers that benchmarks compute from measurements, and the paths of their cameras.
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/camera_control.h"
#include "app/framing/scene_box.h"
#include "app/measure/camera_path.h"
#include "app/measure/load_times.h"
#include "app/measure/measure_view.h"
#include "app/measure/replicate.h"
#include "app/measure/shard.h"
#include "app/measure/statistics.h"
#include "app/report/bench_report.h"
#include "app/report/markdown.h"
#include "app/report/zoom_bundle.h"
#include "base/error.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "support/error_of.h"
#include "support/pool.h"
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

TEST(Statistics, a_summary_has_the_values_of_the_definitions) {
  // 0, 1, 4, .. 400 in the order of measurement: value k of the sorted list is k * k.
  std::vector<double> squares;
  for (int k = 0; k <= 20; ++k) squares.push_back(k * k);
  const Summary summary = summarise(squares);
  EXPECT_DOUBLE_EQ(summary.median, 100);
  EXPECT_DOUBLE_EQ(summary.p05, 1);
  EXPECT_DOUBLE_EQ(summary.p95, 361);
  EXPECT_DOUBLE_EQ(summary.mean, 2870.0 / 21);
  EXPECT_DOUBLE_EQ(summary.drift, 240.5 / 20.5 - 1);  // of 0..81 and of 121..400
  EXPECT_DOUBLE_EQ(relative_spread(squares), 4);
  // Percentile 5 of six values is a quarter of the way from the first to the second.
  const Summary tens = summarise(std::array{60.0, 10.0, 50.0, 20.0, 40.0, 30.0});
  EXPECT_DOUBLE_EQ(tens.p05, 12.5);
  EXPECT_DOUBLE_EQ(tens.p95, 57.5);
  EXPECT_DOUBLE_EQ(tens.median, 35);
  EXPECT_DOUBLE_EQ(tens.drift, 30.0 / 50 - 1);
  EXPECT_DOUBLE_EQ(summarise({}).mean, 0);
  EXPECT_DOUBLE_EQ(relative_spread(std::array{3.0}), 0);
}

TEST(Statistics, rank_correlations_compare_orders_and_ties_share_a_rank) {
  using Values = std::vector<double>;
  EXPECT_EQ(rank_correlation(Values{1, 2, 3}, Values{10, 1e3, 1e9}), 1);
  EXPECT_EQ(rank_correlation(Values{3, 2, 1}, Values{-1, 0, 5}), -1);
  // Without ties it is 1 - 6 sum d^2 / (n^3 - n), here with d^2 = 1, 1, 1, 1.
  EXPECT_NEAR(*rank_correlation(Values{1, 2, 3, 4}, Values{2, 1, 4, 3}), 1 - 6. * 4 / 60, 1e-12);
  // Ranks 1.5, 1.5, 3 and 1, 2, 3: covariance 1.5, variances 1.5 and 2.
  EXPECT_NEAR(*rank_correlation(Values{7, 7, 8}, Values{1, 2, 3}), 1.5 / std::sqrt(3), 1e-12);
  EXPECT_FALSE(rank_correlation(Values{7, 7}, Values{1, 2}));
  EXPECT_FALSE(rank_correlation(Values{}, Values{}));
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
            "bin_ms,sort_ms,blend_ms,psnr_vs_reference,false_positives,false_positive_share,"
            "ssim_vs_reference,flip_vs_reference,repeats,frames,sort_bytes,ms_paper");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_THAT(csv, HasSubstr("\ntiny,0,quadbox,classic,cpu,"));
}

// Every member has a value of its own.
BenchRow full_row() {
  BenchRow r = row("quadbox", 0.5, 700, 3);
  r.pipeline = "fast";
  r.width = 640;
  r.height = 480;
  r.visible = 250;
  r.pairs_per_visible = 2.8;
  r.max_tile = 17;
  r.ms_p05 = 0.25;
  r.ms_p95 = 2;
  r.fps_median = 2000;
  r.frame_ms = 0.625;
  r.preprocess_ms = 0.125;
  r.bin_ms = 0.0625;
  r.sort_ms = 0.1875;
  r.blend_ms = 0.3125;
  r.psnr_vs_reference = 51.5;
  r.ssim_vs_reference = 0.75;
  r.flip_vs_reference = 0.125;
  r.repeats = true;
  r.frames = 40;
  r.sort_bytes = 2000;
  r.ms_paper = 0.875;
  r.false_positives = 70;
  r.false_positive_share = 0.1;
  r.ms_mean = 0.75;
  r.drift = -0.01;
  r.round_ms = {0.5, 0.75};
  r.round_spread = 0.02;
  r.ms_spread = 0.03;
  r.turn_ms = {0.25, 0.5, 2};
  return r;
}

TEST(BenchReport, every_number_stands_in_its_column) {
  const std::string csv = format_csv({full_row()});
  EXPECT_EQ(
      csv.substr(csv.find('\n') + 1),
      "tiny,3,quadbox,fast,cpu,640,480,1000,250,700,2.8000,17,0.5000,0.2500,2.0000,2000.0000,"
      "0.6250,0.1250,0.0625,0.1875,0.3125,51.5000,70,0.1000,0.7500,0.1250,true,40,2000,0.8750\n");
  const nlohmann::ordered_json json = rows_json({full_row()})[0];
  EXPECT_EQ(json, parse_own_json(R"({"scene": "tiny", "camera": "3",
      "mode": "quadbox", "pipeline": "fast", "backend": "cpu", "width": 640, "height": 480,
      "gaussians": 1000, "visible": 250, "pairs": 700, "pairs_per_visible": 2.8, "max_tile": 17,
      "ms_median": 0.5, "ms_p05": 0.25, "ms_p95": 2.0, "fps_median": 2000.0, "frame_ms": 0.625,
      "preprocess_ms": 0.125, "bin_ms": 0.0625, "sort_ms": 0.1875, "blend_ms": 0.3125,
      "psnr_vs_reference": 51.5, "false_positives": 70, "false_positive_share": 0.1,
      "ssim_vs_reference": 0.75, "flip_vs_reference": 0.125, "repeats": true, "frames": 40,
      "sort_bytes": 2000, "ms_paper": 0.875, "view": 3,
      "ms_mean": 0.75, "drift": -0.01, "round_ms": [0.5, 0.75], "round_spread": 0.02,
      "ms_spread": 0.03, "turn_ms": [0.25, 0.5, 2.0]})"));
  EXPECT_EQ(rows_json(read_rows(rows_json({full_row()}))), rows_json({full_row()}));
}

TEST(BenchReport, rows_of_earlier_versions_lack_the_image_quality_and_the_frames) {
  nlohmann::ordered_json rows = rows_json({full_row()});
  for (const char* column : {"ssim_vs_reference", "flip_vs_reference", "repeats", "frames",
                             "sort_bytes", "ms_paper", "ms_spread", "turn_ms"})
    rows[0].erase(column);
  const BenchRow old = read_rows(rows)[0];
  EXPECT_FALSE(old.ssim_vs_reference || old.flip_vs_reference || old.repeats);
  EXPECT_FALSE(old.frames || old.sort_bytes || old.ms_spread);
  EXPECT_EQ(old.psnr_vs_reference, 51.5);
  rows[0].erase("pairs");
  EXPECT_THROW(read_rows(rows), nlohmann::json::exception);
}

TEST(BenchReport, means_over_cameras_and_scenes_are_those_of_the_rows) {
  std::vector<BenchRow> rows = {row("3dgs", 4, 1000, 0), row("quadbox", 1, 300, 0),
                                row("3dgs", 8, 3000, 1), row("quadbox", 2, 500, 1),
                                row("3dgs", 2, 500, 2),  row("quadbox", 2, 100, 2)};
  rows[4].scene = rows[5].scene = "other";
  rows[1].blend_ms = 0.5;
  rows[3].blend_ms = 1;
  rows[1].psnr_vs_reference = 40;
  rows[3].psnr_vs_reference = 50;
  const std::vector<ModeMean> means = mode_means(rows, "3dgs");
  ASSERT_EQ(means.size(), 4u);
  EXPECT_DOUBLE_EQ(means[1].ms, 1.5);
  EXPECT_DOUBLE_EQ(means[1].fps(), 1000 / 1.5);
  EXPECT_DOUBLE_EQ(means[1].pairs, 400);
  EXPECT_DOUBLE_EQ(means[1].stage_ms[3], 0.75);
  EXPECT_DOUBLE_EQ(means[1].psnr.value(), 45);
  EXPECT_DOUBLE_EQ(means[1].ratio.value().value, 4);
  EXPECT_EQ(means[0].psnr, std::nullopt);
  const std::string text = format_markdown(report(rows));
  EXPECT_THAT(text, HasSubstr("\n2 cameras, 0 x 0\n"));
  EXPECT_THAT(text, HasSubstr("## Mean of 2 scenes"));
  // 6 and 2 ms, 2000 and 500 pairs; 1.5 and 2 ms, speed-ups of 4 and 1.
  EXPECT_THAT(text, HasSubstr("| `3dgs` | 1,000 | - | 4.000 | 250.0 | 1.00x | 1,250 |"));
  EXPECT_THAT(text, HasSubstr("| `quadbox` | 1,000 | - | 1.750 | 571.4 | 2.00x | 250 |"));
}

TEST(BenchReport, rows_of_two_pipelines_are_not_averaged) {
  std::vector<BenchRow> rows = {row("3dgs", 2, 1000), row("quadbox", 1, 400), row("3dgs", 8, 1000),
                                row("quadbox", 2, 400)};
  rows[0].pipeline = rows[1].pipeline = "fast";
  const std::string text = format_markdown(report(rows));
  EXPECT_THAT(text, HasSubstr("| `quadbox, fast` | 1,000 | - | 1.000 | 1000 | 2.00x |"));
  EXPECT_THAT(text, HasSubstr("| `quadbox, classic` | 1,000 | - | 2.000 | 500.0 | 4.00x |"));
  for (const Plot& plot : bench_plots(report(rows), false)) {
    EXPECT_THAT(plot.commands, HasSubstr("\"quadbox, fast\"")) << plot.name;
    EXPECT_THAT(plot.commands, HasSubstr("\"quadbox, classic\"")) << plot.name;
  }
}

TEST(ModeTable, shows_times_pairs_and_speed_ups_of_the_median_frames) {
  std::vector<ModeResult> results(2);
  results[0].mode = find_culler("3dgs");
  results[0].frame_ms = {8, 8.2, 8.04, 8.1, 8};
  results[0].stats.tile_pairs = 12345;
  results[0].stats.visible = 1000;
  results[1].mode = find_culler("quadbox");
  results[1].frame_ms = {3.2, 4.1, 3, 3.2, 3.3};
  results[1].psnr = 48.125;
  const std::string text = format_mode_table(results);
  EXPECT_THAT(
      text,
      HasSubstr("\n3dgs                   8.04 \u00b10.05    124.4        12,345          12.35"
                "               1.00x        -  "));
  EXPECT_THAT(
      text,
      HasSubstr("\nquadbox                3.20 \u00b10.05      312             0           0.00"
                "           2.4x \u00b10.4    48.12  "));
}

// Reports the times of a list as the times of its frames, one after another.
class ScriptedRenderer : public Renderer {
 public:
  explicit ScriptedRenderer(std::vector<float> times_ms) : times_ms_(std::move(times_ms)) {}
  void upload(std::shared_ptr<const GaussianCloud>, const Progress&) override {}
  const Frame& render(const Camera&, const RenderSettings&, const Outputs&, const Target&,
                      std::stop_token) override {
    frame_.stats.frame_ms = times_ms_[next_++ % times_ms_.size()];
    return frame_;
  }

 private:
  std::vector<float> times_ms_;
  std::size_t next_ = 0;
  Frame frame_;
};

// The row of a view that was measured in three rounds of two frames, which take these times.
BenchRow three_rounds(std::vector<float> times_ms) {
  Session session;
  session.renderer = std::make_unique<ScriptedRenderer>(std::move(times_ms));
  return measure_view(session, {default_mode()}, test::front_camera(64, 48), {2, 0, 3}, {}).front();
}

TEST(MeasureView, a_row_has_the_counts_of_the_frame_and_the_times_of_all_rounds) {
  const BenchRow timed = three_rounds({4, 2, 5, 1, 3, 6});
  EXPECT_DOUBLE_EQ(timed.ms_median, 3.5);
  EXPECT_DOUBLE_EQ(timed.ms_p05, 1.25);
  EXPECT_DOUBLE_EQ(timed.ms_p95, 5.75);
  EXPECT_DOUBLE_EQ(timed.ms_mean, 3.5);
  EXPECT_DOUBLE_EQ(timed.fps_median, 1000 / 3.5);
  EXPECT_DOUBLE_EQ(timed.drift, 3.0 / 4 - 1);  // of 1, 3, 6 and of 4, 2, 5
  EXPECT_THAT(timed.round_ms, testing::ElementsAre(3, 3, 4.5));
  EXPECT_DOUBLE_EQ(timed.round_spread.value(), (4.5 - 3) / 3.0);

  Session session;
  session.renderer = make_renderer(Backend::cpu, test::pool());
  session.renderer->upload(test::random_cloud(300, 1, 5), {});
  const Camera camera = test::front_camera(64, 48);
  const BenchRow counted =
      measure_view(session, {find_culler("3dgs")}, camera, {1, 0, 1}, {}).front();
  RenderSettings settings;
  settings.mode = find_culler("3dgs");
  Outputs outputs;
  outputs.pairs = outputs.used = true;
  const Frame& frame = session.renderer->render(camera, settings, outputs);
  const std::uint64_t pairs = sum_of(frame.pairs), unused = pairs - sum_of(frame.used);
  EXPECT_EQ(counted.round_spread, std::nullopt) << "one round has no spread";
  EXPECT_EQ(counted.mode, "3dgs");
  EXPECT_EQ(counted.pipeline, "cpu");
  EXPECT_EQ(counted.backend, "cpu");
  EXPECT_EQ(counted.width, 64);
  EXPECT_EQ(counted.height, 48);
  EXPECT_EQ(counted.gaussians, 300u);
  EXPECT_EQ(counted.visible, frame.stats.visible);
  EXPECT_EQ(counted.pairs, pairs);
  EXPECT_EQ(counted.sort_bytes, 8u * counted.visible);
  EXPECT_DOUBLE_EQ(counted.pairs_per_visible, static_cast<double>(pairs) / counted.visible);
  EXPECT_EQ(counted.max_tile, *std::max_element(frame.pairs.begin(), frame.pairs.end()));
  EXPECT_EQ(counted.false_positives, unused);
  EXPECT_GT(unused, 0u);
  EXPECT_DOUBLE_EQ(counted.false_positive_share.value(),
                   static_cast<double>(unused) / static_cast<double>(pairs));
  EXPECT_GT(counted.preprocess_ms, 0);
  EXPECT_LE(counted.preprocess_ms + counted.bin_ms + counted.sort_ms + counted.blend_ms,
            1.001 * counted.frame_ms);
}

TEST(MeasureView, a_row_names_the_pipeline_that_drew) {
  Session session;
  session.renderer = make_renderer(Backend::cpu, test::pool());
  session.renderer->upload(test::random_cloud(50, 1, 5), {});
  const auto drawn_by = [&](int tile_px) {
    session.settings.tile_px = tile_px;
    return measure_view(session, {find_culler("3dgs")}, test::front_camera(64, 48), {1, 0, 1}, {})
        .front()
        .pipeline;
  };
  EXPECT_EQ(drawn_by(kTileSize), "cpu");
  EXPECT_EQ(drawn_by(8), "classic") << "`fast` has tiles of 16 pixels only";
}

TEST(Noise, rounds_whose_medians_differ_by_more_than_three_per_cent_are_told) {
  const BenchRow calm = three_rounds({2.00f, 2.00f, 2.02f, 2.02f, 2.00f, 2.00f});
  EXPECT_NEAR(calm.round_spread.value(), 0.01, 1e-6);
  EXPECT_EQ(calm.frames, 6u) << "of all rounds";
  EXPECT_NEAR(calm.ms_spread.value(), 0.0075, 1e-6) << "half of 2.015 - 2.00";
  EXPECT_EQ(noise_sentence({calm}), "");
  const BenchRow restless = three_rounds({2.0f, 2.0f, 1.9f, 1.9f, 2.0f, 2.0f});
  EXPECT_NEAR(restless.round_spread.value(), 0.05, 1e-6);
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
  EXPECT_THAT(noise_sentence(rows), testing::StartsWith("3 of 3 rows are noisy: the "
                                                        "worst is tiny, camera 1, adr: its later "
                                                        "frames took -8.0 %"));
  EXPECT_EQ(noise_sentence(rows).find('\n'), std::string::npos);
  EXPECT_THAT(noise_markdown(rows), HasSubstr("| tiny | 2 | `exact` | 0 % | +0.0 % | 5.0 % |"));
  EXPECT_THAT(noise_markdown(rows),
              HasSubstr("| tiny | 1 | `adr` | 0 % | -8.0 % | one round has no spread |"));
  EXPECT_THAT(noise_markdown(rows), testing::Not(HasSubstr(" 0.0 %")));
}

TEST(Noise, a_zoom_s_curve_is_noisy_where_the_quartiles_or_the_halves_are_far_apart) {
  std::vector<BenchRow> rows;
  for (int step = 0; step < 3; ++step) {
    for (const char* mode : {"3dgs", "exact"}) {
      rows.push_back(row(mode, 2, 1, step));
      rows.back().ms_spread = 0.2;  // 10 % of the median
    }
  }
  EXPECT_EQ(noisy_steps(rows), "");
  rows[1].ms_spread = 0.21;
  rows[4].drift = -0.11;
  EXPECT_EQ(noisy_steps(rows), "3dgs 1, exact 1 of 3");
  rows[1].ms_spread.reset();
  rows[1].drift = 0.5;
  EXPECT_EQ(noisy_steps(rows), "3dgs 1 of 3") << "one frame has no noise";
  EXPECT_EQ(noisy_steps({}), "");
}

TEST(Shard, every_view_belongs_to_exactly_one_shard) {
  for (std::size_t view = 0; view < 20; ++view) {
    int takers = 0;
    for (const char* text : {"1/3", "2/3", "3/3"})
      takers += parse_shard("--shard", text).takes(view) ? 1 : 0;
    EXPECT_EQ(takers, 1);
  }
  const Shard second = parse_shard("--shard", "2/3");
  EXPECT_TRUE(!second.takes(0) && second.takes(1) && !second.takes(2) && second.takes(4));
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
  const auto renderer = make_renderer(Backend::cpu, test::pool());
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
  bundle.rows[1].ms_spread = 0.5;
  std::ofstream(folder / "zoom.json") << format_zoom_json(bundle);
  const ZoomBundle read = read_zoom_json(folder / "zoom.json");
  EXPECT_EQ(format_zoom_json(read), format_zoom_json(bundle));
  EXPECT_THAT(format_zoom_json(bundle), HasSubstr(R"("noisy_steps": "quadbox 1 of 1")"));
  EXPECT_TRUE(count_differences(bundle.rows, read.rows).empty());
  nlohmann::ordered_json edited = parse_own_json(format_zoom_json(bundle));
  edited["steps"] = 1e30;
  std::ofstream(folder / "edited.json") << edited;
  EXPECT_THAT(test::error_of([&] { read_zoom_json(folder / "edited.json"); }),
              HasSubstr("1e+30 is not a whole number"));
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
  const std::vector<Camera> path = sample_path(keyframes, 7);
  ASSERT_EQ(path.size(), 7u);
  EXPECT_LT(glm::length(path[0].position() - keyframes[0].camera.position()), 1e-9);
  EXPECT_LT(glm::length(path[6].position() - keyframes[4].camera.position()), 1e-9);
  EXPECT_LT(glm::length(path[3].position() - camera_at(keyframes, 5).position()), 1e-9);
}

TEST(CameraPath, between_two_keyframes_is_straight_and_zooms_evenly) {
  const std::vector<Keyframe> keyframes = {
      {1, look_at({0, 0, 0}, {0, 0, 1}, {0, -1, 0}, 1.0, 64, 48)},
      {5, look_at({4, 8, 0}, {4, 8, 1}, {0, -1, 0}, 0.5, 64, 48)}};
  const Camera quarter = camera_at(keyframes, 2), before = camera_at(keyframes, -7);
  EXPECT_LT(glm::length(quarter.position() - glm::dvec3(1, 2, 0)), 1e-9);
  const double from = keyframes[0].camera.focal_px.y, to = keyframes[1].camera.focal_px.y;
  EXPECT_NEAR(quarter.focal_px.y, from * std::pow(to / from, 0.25), 1e-9);
  EXPECT_LT(glm::length(before.position()), 1e-9);
}

TEST(LoadTimes, the_table_shows_milliseconds_and_ratios) {
  const LoadTimes times{"a.spz", "spz", 1873, 1000, 30, 10, 15, 10, 20};
  EXPECT_THAT(format_load_times({times}),
              HasSubstr("\n| a.spz | spz | 1.0 kB | 1,873 | 30.0 | 10.0 | 15.0 | 10.0 | 3.00 | "
                        "20.0 | 1.50 |\n"));
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
  const glm::vec3 step = 1.1f * core_box(cloud).size();
  const auto offset = [&](std::size_t copy) {
    return grid.positions[copy * 100 + 5] - cloud.positions[5];
  };
  EXPECT_LT(glm::length(offset(2) - glm::vec3(0, 0, 2 * step.z)), 1e-4f * step.z);
  EXPECT_LT(glm::length(offset(4) - glm::vec3(step.x, 0, step.z)), 1e-4f * step.z);
}

}  // namespace
}  // namespace qs
