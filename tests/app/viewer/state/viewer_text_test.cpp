// SPDX-License-Identifier: MIT
//
// The numbers that the viewer's panels show, compared with numbers that are computed here.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/trigonometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/framing/camera_control.h"
#include "app/support/driven_viewer.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/mode_table.h"
#include "app/viewer/state/training_actions.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "support/scenes.h"

namespace qs {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;

std::string value_of(const std::vector<Fact>& facts, const std::string& label) {
  for (const Fact& fact : facts) {
    if (fact.label == label) return fact.value;
  }
  return "no fact " + label;
}

BenchRow row_of_mode(const std::string& mode, double ms, std::uint64_t pairs) {
  BenchRow row;
  row.mode = mode;
  row.pipeline = "fast";
  row.ms_median = ms;
  row.fps_median = 1000 / ms;
  row.pairs = pairs;
  return row;
}

// A viewer that shows a frame of a scene with known numbers.
Viewer known_viewer() {
  Viewer viewer;
  viewer.scene.emplace();
  viewer.scene->path = "/data/garden.ply";
  viewer.scene->name = "garden";
  viewer.scene->format = "ply";
  viewer.scene->gaussians = 5834784;
  viewer.scene->file_bytes = 1447026432;
  viewer.scene->sh_degree = 3;
  viewer.scene->core = {glm::vec3(-1, 0, 0), glm::vec3(1.5f, 1, 1)};
  viewer.camera = test::front_camera(640, 480);
  viewer.camera.view_from_world[3] = glm::dvec3(1, -2, 3.4567);
  RenderStats& stats = viewer.shown.stats;
  stats.frame_ms = 4;
  stats.present_ms = 0.25f;
  stats.tile_pairs = 1796342;
  stats.visible = 1234567;
  stats.gaussians = 5834784;
  stats.max_pairs_in_a_tile = 4321;
  return viewer;
}

// ---- performance -------------------------------------------------------------------------------
TEST(HudText, the_frame_s_numbers_are_those_of_its_statistics) {
  Viewer viewer = known_viewer();
  viewer.display_fps = 59.94;
  viewer.present_ms = 0.5f;
  viewer.process_bytes = 1'234'000'000;
  viewer.gpu_bytes = 2'500'000;
  const std::vector<Fact> facts = hud_facts(viewer);
  EXPECT_EQ(value_of(facts, "render"), "~4.0 ms, ~250 FPS");  // one frame, 1000 / 4
  EXPECT_EQ(value_of(facts, "display"), "59.9 FPS");
  EXPECT_EQ(value_of(facts, "present"), "0.750 ms, through the host");  // 0.25 + 0.5
  EXPECT_EQ(value_of(facts, "tile pairs"), "1,796,342");
  EXPECT_EQ(value_of(facts, "visible"), "1,234,567 of 5,834,784");
  EXPECT_EQ(value_of(facts, "largest tile"), "4,321 pairs");
  EXPECT_EQ(value_of(facts, "memory"), "1.2 GB, GPU 2.5 MB");
  viewer.gpu_bytes = 0;
  EXPECT_EQ(value_of(hud_facts(viewer), "memory"), "1.2 GB");
  viewer.shown.interop = true;
  EXPECT_EQ(value_of(hud_facts(viewer), "present"), "0.750 ms, by interop");
}

TEST(HudText, an_empty_window_has_no_times) {
  const std::vector<Fact> facts = hud_facts(Viewer());
  EXPECT_EQ(value_of(facts, "render"), "-");
  EXPECT_EQ(value_of(facts, "display"), "at rest");
}

TEST(HudText, digits_follow_the_size_of_a_number) {
  EXPECT_EQ(ms_text(0.00049), "0.000");
  EXPECT_EQ(ms_text(12.34567), "12.346");
  EXPECT_EQ(fps_text(999.94), "999.9");
  EXPECT_EQ(fps_text(1000), "1000");
  EXPECT_EQ(signed_text(-1234567), "\u22121,234,567");
  EXPECT_EQ(signed_text(5), "+5");
  EXPECT_EQ(signed_text(0), "+0");
}

TEST(HudText, the_table_shows_the_numbers_of_the_csv) {
  Viewer viewer = known_viewer();
  BenchRow base = row_of_mode("3dgs", 1.9518, 5227642);
  base.pairs_per_visible = 20.481;
  BenchRow quad = row_of_mode("quadbox", 0.9612, 1796352);
  quad.false_positives = 449088;
  quad.false_positive_share = 0.25;  // 449088 of 1796352
  viewer.numbers = {viewer.view_version, {base, quad}};
  EXPECT_TRUE(numbers_are_current(viewer));
  EXPECT_THAT(format_csv(viewer.numbers.rows), HasSubstr("1.9518"));
  const std::vector<HudRow> table = hud_rows(viewer);
  ASSERT_THAT(table, SizeIs(culler_count()));
  EXPECT_EQ(table[0].name.text, "3dgs");
  EXPECT_EQ(table[0].ms.text, "1.952");
  EXPECT_EQ(table[0].fps.text, "512.3");  // 1000 / 1.9518
  EXPECT_EQ(table[0].pairs.text, "5,227,642");
  EXPECT_EQ(table[0].per_visible.text, "20.48");
  EXPECT_EQ(table[0].unused.text, "-");
  EXPECT_EQ(table[0].ratio.text, "1.00x");
  EXPECT_EQ(table[1].ms.text, "-");
  EXPECT_EQ(table[1].ratio.text, "-");
  EXPECT_EQ(table[4].ratio.text, "2.03x");  // 1.9518 / 0.9612
  EXPECT_EQ(table[4].fps.text, "1040");     // 1000 / 0.9612
  EXPECT_EQ(table[4].unused.text, "25.0 %");
  EXPECT_EQ(value_of(hud_facts(viewer), "unused"), "449,088 pairs, 25.0 %");
  viewer.zoom.running = true;  // its frames are of other views
  EXPECT_FALSE(numbers_are_current(viewer));
  EXPECT_EQ(value_of(hud_facts(viewer), "unused"), "no fact unused");
  viewer.zoom.running = false;
  ++viewer.view_version;
  EXPECT_FALSE(numbers_are_current(viewer));
  EXPECT_EQ(value_of(hud_facts(viewer), "unused"), "no fact unused");
}

TEST(HudText, both_pipelines_are_compared_with_their_own_3dgs) {
  Viewer viewer = known_viewer();
  viewer.backend = Backend::cuda;
  viewer.settings.pipeline = Pipeline::fast;
  std::vector<BenchRow> rows;
  for (const auto& [mode, ms, pipeline] :
       {std::tuple("3dgs", 2.0, "fast"), std::tuple("quadbox", 1.0, "fast"),
        std::tuple("3dgs", 9.0, "classic"), std::tuple("quadbox", 3.0, "classic")}) {
    rows.push_back(row_of_mode(mode, ms, 1));
    rows.back().pipeline = pipeline;
  }
  viewer.numbers = {viewer.view_version, rows};
  EXPECT_EQ(other_pipeline(viewer), Pipeline::classic);
  HudRow quad = hud_rows(viewer)[4];
  EXPECT_EQ(quad.ms.text, "1.000");
  EXPECT_EQ(quad.ratio.text, "2.00x");
  EXPECT_EQ(quad.other_ms.text, "3.000");
  EXPECT_EQ(quad.other_ratio.text, "3.00x");
  viewer.settings.pipeline = Pipeline::classic;
  quad = hud_rows(viewer)[4];
  EXPECT_EQ(quad.ms.text, "3.000");
  EXPECT_EQ(quad.other_ratio.text, "2.00x");
}

// A row whose frames took these times.
BenchRow row_of_frames(const std::string& mode, std::vector<double> round_ms) {
  std::vector<double> sorted = round_ms;
  std::sort(sorted.begin(), sorted.end());
  BenchRow row = row_of_mode(mode, sorted[sorted.size() / 2], 1);
  row.round_ms = std::move(round_ms);
  return row;
}

TEST(HudText, a_number_has_only_the_digits_that_its_uncertainty_leaves) {
  EXPECT_EQ(three_digits(0.1494), "0.149");
  EXPECT_EQ(three_digits(2.5), "2.50");
  EXPECT_EQ(three_digits(20.251), "20.3");
  EXPECT_EQ(three_digits(817.801), "818");
  EXPECT_EQ(counted(1, "Gaussian"), "1 Gaussian");
  EXPECT_EQ(counted(34321, "Gaussian"), "34,321 Gaussians");
  EXPECT_EQ(significant(12.3456, 0.04), "12.35");
  EXPECT_EQ(significant(12.3456, 0.4), "12.3");
  EXPECT_EQ(significant(12.3456, 0.99), "12.3");
  EXPECT_EQ(significant(12.3456, 1), "12");
  EXPECT_EQ(significant(1234, 40), "1230");
  EXPECT_EQ(significant(12.3456, 1e-9), "12.346");
  EXPECT_EQ(significant(12.3456, 0), "12.346");
}

TEST(HudText, a_time_has_its_spread_and_a_ratio_its_interval) {
  Viewer viewer = known_viewer();
  viewer.numbers = {viewer.view_version,
                    {row_of_frames("3dgs", {10.24, 10.0, 10.1, 10.3, 9.9}),
                     row_of_frames("quadbox", {5.0, 5.12, 4.9, 5.0, 5.2})}};
  const std::vector<HudRow> table = hud_rows(viewer);
  // Quartiles of 9.9, 10.0, 10.1, 10.24, 10.3 are 10.0 and 10.24.
  EXPECT_EQ(table[0].ms.text, "10.1 \u00b10.1");
  EXPECT_EQ(table[0].ratio.text, "1.00x");
  EXPECT_EQ(table[4].ms.text, "5.00 \u00b10.06");
  // The mean logarithm of 10.24/5, 10/5.12, 10.1/4.9, 10.3/5, 9.9/5.2 is log 2.0042; its standard
  // error is 0.01630, and the t factor of four degrees of freedom is 2.776.
  EXPECT_EQ(table[4].ratio.text, "2.00x \u00b10.09");
  EXPECT_FALSE(table[4].ms.noisy);
  EXPECT_EQ(table[1].ratio.text, "-");
  EXPECT_EQ(trust_text(viewer, table[4].mode),
            "median of 5 frames; the middle half of them spans 0.1 ms\n"
            "95 % interval of the ratio to 3dgs: 1.92 to 2.10");
  EXPECT_EQ(trust_text(viewer, 2), "not measured yet");
}

TEST(HudText, an_interval_that_contains_one_or_a_wide_spread_is_noisy) {
  Viewer viewer = known_viewer();
  viewer.numbers = {viewer.view_version,
                    {row_of_frames("3dgs", {10, 10, 10, 10, 10}),
                     row_of_frames("adr", {9.9, 10.1, 9.8, 10.2, 10.1}),
                     row_of_frames("exact", {3, 5, 4, 3, 5})}};
  const std::vector<HudRow> table = hud_rows(viewer);
  EXPECT_FALSE(table[0].ms.noisy);
  EXPECT_TRUE(table[1].ratio.noisy);
  EXPECT_THAT(table[1].ratio.text, testing::EndsWith(" noisy"));
  EXPECT_THAT(trust_text(viewer, 2), HasSubstr("do not show which is faster"));
  EXPECT_TRUE(table[5].ms.noisy) << "the quartiles are 3 and 5: a quarter of the median of 4";
  EXPECT_FALSE(table[5].ratio.noisy) << "it was faster in every round";
  EXPECT_THAT(table[5].ratio.text, testing::Not(testing::EndsWith(" noisy")));
}

TEST(ModeTable, a_narrow_table_keeps_fps_and_pairs_and_drops_stages_before_milliseconds) {
  const std::vector<TableColumn> all = table_columns(known_viewer());
  const auto titles = [&](float width) { return titles_of(columns_that_fit(all, width, 0.5f)); };
  EXPECT_THAT(titles(1000), ElementsAre("mode", "FPS", "pairs", "vs 3dgs", "ms", "unused",
                                        "per visible", "stages"));
  EXPECT_THAT(titles(32), ElementsAre("mode", "FPS", "pairs", "vs 3dgs", "ms"));
  EXPECT_THAT(titles(26), ElementsAre("mode", "FPS", "pairs", "vs 3dgs"));
  EXPECT_THAT(titles(19), ElementsAre("mode", "FPS", "pairs"));
  EXPECT_THAT(titles(0), ElementsAre("mode", "FPS"));
}

TEST(ModeTable, rows_are_ordered_by_a_column_and_modes_without_a_number_come_last) {
  Viewer viewer = known_viewer();
  viewer.numbers = {
      viewer.view_version,
      {row_of_mode("3dgs", 6, 9), row_of_mode("exact", 2, 1), row_of_mode("adr", 3, 4)}};
  std::vector<HudRow> rows = hud_rows(viewer);
  sort_rows(
      rows, [](const HudRow& row) { return row.fps.value; }, true);
  EXPECT_EQ(rows[0].name.text, "exact");
  EXPECT_EQ(rows[1].name.text, "adr");
  EXPECT_EQ(rows[2].name.text, "3dgs");
  EXPECT_EQ(rows[3].fps.text, "-");
  sort_rows(
      rows, [](const HudRow& row) { return row.pairs.value; }, false);
  EXPECT_EQ(rows[0].name.text, "exact");
  EXPECT_EQ(rows[2].name.text, "3dgs");
}

TEST(ModeTable, is_copied_as_csv_markdown_and_latex_with_its_size) {
  Viewer viewer = known_viewer();
  BenchRow row = row_of_frames("3dgs", {10, 10.2, 9.8});
  row.width = 640;
  row.height = 480;
  row.false_positives = 1;
  row.false_positive_share = 0.25;
  viewer.numbers = {viewer.view_version, {row}};
  EXPECT_EQ(table_text(viewer, TableFormat::csv), format_csv(viewer.numbers.rows));
  const std::string markdown = table_text(viewer, TableFormat::markdown);
  EXPECT_THAT(markdown, testing::StartsWith("garden, 640 x 480, "));
  EXPECT_THAT(markdown, HasSubstr("| mode | FPS | pairs | vs 3dgs | ms | unused | per visible |"));
  EXPECT_THAT(markdown, HasSubstr("| 3dgs | "));
  const std::string latex = table_text(viewer, TableFormat::latex);
  EXPECT_THAT(latex, HasSubstr("\\begin{tabular}{lrrrrrr}"));
  EXPECT_THAT(latex, HasSubstr("25.0 \\%"));
  EXPECT_THAT(latex, HasSubstr("$\\pm$"));
  EXPECT_THAT(latex, testing::Not(HasSubstr("\u00b1")));
}

TEST(ModeGlance, a_switch_tells_both_modes_of_the_same_view) {
  Viewer viewer = known_viewer();
  viewer.mode_switch = {find_culler("3dgs"), find_culler("quadbox"), 0};
  EXPECT_EQ(switch_text(viewer), "") << "nothing is known";
  viewer.numbers = {viewer.view_version,
                    {row_of_mode("3dgs", 2, 5227642), row_of_mode("quadbox", 0.9612, 1796352)}};
  EXPECT_EQ(switch_text(viewer), "FPS 500.0 -> 1040, pairs 5,227,642 -> 1,796,352");
  ++viewer.view_version;  // the numbers and the frames are of an earlier view
  EXPECT_EQ(switch_text(viewer), "");
}

TEST(HudText, a_reduced_frame_s_numbers_say_its_size_and_are_faint) {
  Viewer viewer = known_viewer();
  EXPECT_FALSE(status_line(viewer).faint);
  viewer.shown.divisor = 2;
  EXPECT_TRUE(status_line(viewer).faint);
  EXPECT_THAT(status_line(viewer).numbers, HasSubstr("~250 FPS at 1/2"));
}

TEST(HudText, the_picture_s_time_is_the_table_s_once_the_table_is_of_it) {
  Viewer viewer = known_viewer();
  viewer.camera.width = 1280;
  viewer.camera.height = 720;
  viewer.shown.mode = viewer.settings.mode = find_culler("quadbox");
  viewer.shown.version = viewer.version;
  BenchRow row = row_of_mode("quadbox", 5, 1796352);
  row.round_ms = {4.9, 5.0, 5.1, 4.95, 5.05};
  viewer.numbers = {viewer.view_version, {row}};
  const HudRow shown = hud_rows(viewer)[static_cast<std::size_t>(viewer.shown.mode - 1)];
  const std::string time = fmt::format("{} ms, {} FPS", shown.ms.text, shown.fps.text);
  EXPECT_THAT(status_line(viewer).numbers, HasSubstr(time + "  "));
  EXPECT_EQ(value_of(hud_facts(viewer), "render"), time);
  EXPECT_EQ(badge_lines(viewer)[0], shown.fps.text + " FPS");
  EXPECT_THAT(status_line(viewer).numbers, StartsWith("quadbox  "));
  viewer.bare_size = {1600, 900};
  // The table is of another size than the picture: so are all numbers of the line and the panel.
  viewer.shown.stats.tile_pairs = 1000000;
  viewer.shown.stats.visible = 99;
  viewer.numbers.rows[0].width = 1600;
  viewer.numbers.rows[0].height = 900;
  viewer.numbers.rows[0].visible = 1234;
  viewer.numbers.rows[0].max_tile = 77;
  EXPECT_THAT(status_line(viewer).numbers, StartsWith("quadbox at 1600 x 900  "));
  EXPECT_THAT(status_line(viewer).numbers, HasSubstr(time + "  "));
  EXPECT_THAT(status_line(viewer).numbers, HasSubstr("1,796,352 pairs"));
  const std::vector<Fact> facts = hud_facts(viewer);
  EXPECT_EQ(value_of(facts, "size"), "1600 x 900");
  EXPECT_EQ(value_of(facts, "tile pairs"), "1,796,352");
  EXPECT_EQ(value_of(facts, "visible"), "1,234 of 5,834,784");
  EXPECT_EQ(value_of(facts, "largest tile"), "77 pairs");
  // The badge goes into saved pictures, so it is of the picture.
  EXPECT_THAT(badge_lines(viewer), ElementsAre("~250 FPS", "1,000,000 pairs", "1280 x 720", "cpu"));
  viewer.settings.splat_scale = 0.5625f;
  EXPECT_EQ(badge_lines(viewer).back(), "splat scale 0.562");
  viewer.settings.splat_scale = 1;
  // A frame that does more than the mode is not the table's.
  viewer.shown.heatmap.emplace();
  EXPECT_THAT(status_line(viewer).numbers, HasSubstr("~250 FPS"));
  viewer.shown.heatmap.reset();
  ++viewer.view_version;
  EXPECT_THAT(status_line(viewer).numbers, HasSubstr("~250 FPS"));
}

TEST(HudText, beside_the_trainer_nothing_is_a_measurement) {
  Viewer viewer = known_viewer();
  EXPECT_EQ(hud_caveat(viewer), "");
  viewer.training.emplace();
  ASSERT_TRUE(is_training(viewer));
  EXPECT_EQ(hud_caveat(viewer), "beside the trainer: not a measurement");
  EXPECT_THAT(hud_status(viewer), HasSubstr("not measured beside the trainer"));
}

TEST(HudText, ratios_are_relative_to_the_chosen_baseline) {
  Viewer viewer = known_viewer();
  EXPECT_EQ(table_columns(viewer)[3].title, "vs 3dgs");
  viewer.numbers = {viewer.view_version, {row_of_mode("3dgs", 6, 1), row_of_mode("adr", 3, 1)}};
  viewer.baseline = find_culler("adr");
  EXPECT_EQ(table_columns(viewer)[3].title, "vs adr");
  EXPECT_EQ(hud_rows(viewer)[0].ratio.text, "0.50x");
  EXPECT_EQ(hud_rows(viewer)[1].ratio.text, "1.00x");
}

TEST(HudText, stages_stand_in_their_order) {
  BenchRow row;
  row.preprocess_ms = 0.125;
  row.bin_ms = 0.25;
  row.sort_ms = 0.5;
  row.blend_ms = 1;
  EXPECT_THAT(stages_of(row), ElementsAre(0.125, 0.25, 0.5, 1.0));
  EXPECT_EQ(stages_text(row), "preprocess 0.125 ms\nbin 0.250 ms\nsort 0.500 ms\nblend 1.000 ms");
}

TEST(HudText, a_stage_that_is_part_of_others_says_so) {
  BenchRow row;
  row.backend = "cuda";
  row.pipeline = "fast";
  row.preprocess_ms = 0.125;
  EXPECT_EQ(stages_text(row),
            "preprocess 0.125 ms\nbin in preprocess and sort\nsort 0.000 ms\nblend 0.000 ms");
  row.pipeline = "classic";
  EXPECT_THAT(stages_text(row), HasSubstr("\nbin 0.000 ms\n"));
}

TEST(HudText, the_panel_names_the_pipeline_that_drew_the_picture) {
  Viewer viewer = known_viewer();
  viewer.backend = Backend::cuda;
  viewer.settings.pipeline = Pipeline::fast;
  const auto drawn = [&] {
    for (const Fact& fact : hud_facts(viewer)) {
      if (fact.label == "drawn by") return fact.value;
    }
    return std::string();
  };
  EXPECT_EQ(drawn(), "cuda fast");
  viewer.shown.stats.pipeline = Pipeline::classic;
  EXPECT_EQ(drawn(), "cuda classic");
}

TEST(HudText, the_plot_s_caption_names_its_longest_frame) {
  Viewer viewer;
  viewer.frame_ms = {1, 2.5f, 2};
  EXPECT_EQ(frame_plot_text(viewer), "render ms, last 3 frames, 0 to 2.50");
}

TEST(HudText, a_hindered_frame_is_no_measurement) {
  Viewer viewer;
  EXPECT_EQ(hud_caveat(viewer), "") << "frames on demand are the rule";
  viewer.on_demand = false;
  EXPECT_THAT(hud_caveat(viewer), HasSubstr("waits for the display"));
  viewer.vsync = false;
  EXPECT_EQ(hud_caveat(viewer), "");
  viewer.shown.divisor = 2;
  EXPECT_EQ(hud_caveat(viewer), "drawn at 1/2 size: not a measurement");
  viewer.shown.heatmap.emplace();
  viewer.shown.other.emplace();
  EXPECT_EQ(hud_caveat(viewer),
            "drawn at 1/2 size, with a heat map, in a split window: not a measurement");
}

TEST(HudText, a_picture_without_hidden_gaussians_says_what_was_listed) {
  test::DrivenScene driven(0);
  driven.apply([](Viewer& v) {
    v.shown.stats.gaussians = 60'000'000;
    v.shown.stats.listed = 3'200'000;
    v.shown.stats.is_occluded = true;
  });
  const Viewer& viewer = driven.viewer;
  EXPECT_EQ(hud_caveat(viewer), "without hidden Gaussians: not a measurement");
  const std::string line = status_line(viewer).numbers;
  EXPECT_THAT(line, HasSubstr("3,200,000 pairs listed"));
  EXPECT_THAT(line, HasSubstr("60,000,000 Gaussians, hidden ones left out"));
  for (const Fact& fact : hud_facts(viewer)) {
    EXPECT_NE(fact.label, "visible");
    EXPECT_NE(fact.label, "largest tile");
    if (fact.label == "tile pairs") {
      EXPECT_EQ(fact.value, "3,200,000 listed");
    }
  }
}

TEST(HudText, the_state_of_the_table_is_said) {
  Viewer viewer;
  const char* measuring = "measuring all modes for this view ...";
  EXPECT_EQ(hud_status(viewer), measuring) << "it begins at once";
  viewer.last_motion = viewer.now;
  EXPECT_EQ(hud_status(viewer), "not measured yet; measured once this view is still");
  viewer.numbers = {viewer.view_version,
                    {row_of_frames("3dgs", {1, 2, 3}), row_of_frames("adr", {1, 2})}};
  EXPECT_EQ(hud_status(viewer),
            "all modes measured off screen for this view: medians of 2 frames each");
  viewer.measuring = true;
  EXPECT_EQ(
      hud_status(viewer),
      "all modes measured off screen for this view: medians of 2 frames each, measuring more ...");
  viewer.measuring = false;
  ++viewer.view_version;
  EXPECT_EQ(hud_status(viewer), "not measured yet; measured once this view is still");
  viewer.now += 1;
  EXPECT_EQ(hud_status(viewer), measuring);
  viewer.playback.running = true;
  EXPECT_EQ(hud_status(viewer), "not measured yet; measured once this view is still");
  viewer.on_demand = false;
  EXPECT_EQ(hud_status(viewer),
            "not measured yet; all modes are measured while drawing on demand only");
  viewer.measuring = true;
  EXPECT_EQ(hud_status(viewer), measuring);
  viewer.numbers.version = viewer.view_version;
  viewer.zoom.running = true;
  EXPECT_EQ(hud_status(viewer), "recording a zoom") << "the camera of this view is not shown";
}

// ---- the split window ---------------------------------------------------------------------------
TEST(PanelText, the_split_window_says_how_its_frames_differ) {
  Viewer viewer = known_viewer();
  EXPECT_THAT(split_facts(viewer), SizeIs(0));
  ShownOther other;
  other.variant = {find_culler("3dgs"), kDefaultPipeline, Backend::cpu};
  other.stats.tile_pairs = 5227642;
  other.pixels.psnr = 41.256;
  other.pixels.largest = 7;
  other.pixels.largest_at = {12, 34};
  other.pixels.pixels = 98765;
  other.pairs.emplace();
  other.pairs->total = 1796342 - 5227642;
  viewer.shown.other = other;
  std::vector<Fact> facts = split_facts(viewer);
  EXPECT_EQ(value_of(facts, "PSNR"), "41.26 dB");
  EXPECT_EQ(value_of(facts, "largest error"), "7/255 at 12, 34");
  EXPECT_EQ(value_of(facts, "pixels that differ"), "98,765");
  EXPECT_EQ(value_of(facts, "tile pairs"),
            "1,796,342 and 5,227,642: \u22123,431,300, \u221265.6 %");
  EXPECT_THAT(split_names(viewer), ElementsAre("quadbox", "3dgs"));
  viewer.split.flipped = true;
  EXPECT_THAT(split_names(viewer), ElementsAre("3dgs", "quadbox"));
  viewer.shown.other->pixels = {};
  viewer.shown.other->pixels.psnr = INFINITY;
  facts = split_facts(viewer);
  EXPECT_EQ(value_of(facts, "PSNR"), "equal");
  EXPECT_EQ(value_of(facts, "largest error"), "0");
}

TEST(PanelText, a_scene_beside_is_named_with_the_numbers_of_both) {
  Viewer viewer = known_viewer();
  viewer.scene->path = "/data/one/garden.ply";
  viewer.shown.stats.frame_ms = 4;
  ShownOther other;
  other.variant = viewer.variant();
  other.scene = SceneBeside{"/data/two/house.spz", 1234};
  other.stats.frame_ms = 2.5f;
  other.stats.tile_pairs = 5678;
  viewer.shown.other = other;
  EXPECT_THAT(split_names(viewer), ElementsAre("garden", "house"));
  EXPECT_EQ(
      status_line(viewer).numbers,
      "garden | house  \u00b7  quadbox  \u00b7  ~4.0 | ~2.5 ms  \u00b7  1,796,342 | 5,678 pairs");
  EXPECT_THAT(value_of(split_facts(viewer), "Gaussians"), testing::EndsWith(" and 1,234"));
  viewer.split.flipped = true;
  EXPECT_EQ(
      status_line(viewer).numbers,
      "house | garden  \u00b7  quadbox  \u00b7  ~2.5 | ~4.0 ms  \u00b7  5,678 | 1,796,342 pairs");
  viewer.shown.other->scene->path = "/data/two/garden.ply";
  EXPECT_THAT(split_names(viewer), ElementsAre("/data/two/garden.ply", "/data/one/garden.ply"));
  viewer.shown.other->scene->path = viewer.scene->path;
  viewer.levels.emplace();
  EXPECT_THAT(split_names(viewer), ElementsAre("garden, all leaves", "garden, levels of detail"));
}

TEST(PanelText, differences_are_shown_by_the_chosen_factor_or_by_one_from_the_frames) {
  Viewer viewer = known_viewer();
  EXPECT_EQ(shown_amplification(viewer), 1);
  viewer.shown.other.emplace();
  for (const auto& [usual, factor] : {std::pair(0, 128),
                                      {1, 128},
                                      {2, 64},
                                      {3, 64},
                                      {4, 32},
                                      {16, 8},
                                      {127, 2},
                                      {128, 1},
                                      {255, 1}}) {
    viewer.shown.other->pixels.usual = usual;
    EXPECT_EQ(shown_amplification(viewer), factor) << usual;
    EXPECT_EQ(shown_split(viewer).amplification, factor);
  }
  viewer.split.amplification = 16;
  EXPECT_EQ(shown_amplification(viewer), 16);
  const std::vector<BarTick> ticks = difference_legend(16).ticks;
  ASSERT_THAT(ticks, SizeIs(2));
  EXPECT_EQ(ticks[0].text, "0");
  EXPECT_EQ(ticks[1].text, "15.9 / 255");  // 255 / 16
}

TEST(PanelText, the_reference_s_verdict_names_the_pixel_and_the_reason) {
  ReferenceComparison comparison;
  comparison.variant = {find_culler("dualbox"), kDefaultPipeline, Backend::cpu};
  comparison.tolerance = 2;
  comparison.verdict.region = {10, 20, 266, 276};
  comparison.verdict.difference.psnr = 71.5;
  comparison.verdict.difference.largest = 1;
  comparison.verdict.difference.largest_at = {3, 4};
  std::vector<Fact> facts = verdict_facts(comparison);
  EXPECT_EQ(value_of(facts, "frame"), "dualbox, cpu");
  EXPECT_EQ(value_of(facts, "pixels"), "256 x 256 from 10, 20");
  EXPECT_EQ(value_of(facts, "verdict"), "equal within 2/255");
  EXPECT_EQ(value_of(facts, "PSNR"), "71.50 dB");
  EXPECT_EQ(value_of(facts, "largest error"), "1/255 at 3, 4");
  EXPECT_EQ(value_of(facts, "first pixel"), "no fact first pixel");
  comparison.verdict.difference.pixels = 12345;
  comparison.verdict.difference.first = {40, 50};
  comparison.verdict.tile = 67;
  comparison.verdict.gaussian = 89;
  comparison.verdict.why = Disagreement::missing;
  facts = verdict_facts(comparison);
  EXPECT_EQ(value_of(facts, "verdict"), "12,345 differ by more than 2/255");
  EXPECT_EQ(value_of(facts, "first pixel"), "40, 50 in tile 67, ringed in the picture");
  EXPECT_EQ(value_of(facts, "reason"), "Gaussian 89: the frame does not blend it");
  comparison.verdict.gaussian.reset();
  comparison.verdict.why = Disagreement::rounding;
  EXPECT_EQ(value_of(verdict_facts(comparison), "reason"), "the pixel differs by rounding only");
}

TEST(PanelText, the_verdict_is_current_for_its_view_and_mode_and_not_while_a_zoom_moves) {
  Viewer viewer = known_viewer();
  EXPECT_FALSE(verdict_is_current(viewer));
  viewer.comparison.emplace();
  viewer.comparison->view_version = viewer.view_version;
  viewer.comparison->variant = viewer.variant();
  EXPECT_TRUE(verdict_is_current(viewer));
  ++viewer.version;
  EXPECT_TRUE(verdict_is_current(viewer));
  viewer.zoom.running = true;
  EXPECT_FALSE(verdict_is_current(viewer));
  viewer.zoom.running = false;
  viewer.settings.pipeline = Pipeline::classic;
  EXPECT_FALSE(verdict_is_current(viewer));
  viewer.settings.pipeline = kDefaultPipeline;
  ++viewer.view_version;
  EXPECT_FALSE(verdict_is_current(viewer));
}

TEST(PanelText, the_scale_of_pair_differences_is_symmetric) {
  ShownFrame shown;
  shown.other.emplace().pairs_scale = {500, 2500};
  const std::vector<BarTick> ticks = pair_legend(shown).ticks;
  ASSERT_THAT(ticks, SizeIs(3));
  EXPECT_EQ(ticks[0].text, "\u22122,500");
  EXPECT_EQ(ticks[1].text, "0");
  EXPECT_EQ(ticks[1].at, 0.5f);
  EXPECT_EQ(ticks[2].text, "+2,500 pairs in a tile");
}

TEST(PanelText, parts_that_do_not_fit_are_left_out_whole) {
  const auto fits = [](std::size_t most) {
    return [most](const std::string& text) { return text.size() <= most; };
  };
  EXPECT_EQ(fitting_parts("one | two | three", " | ", fits(100)), "one | two | three");
  EXPECT_EQ(fitting_parts("one | two | three", " | ", fits(16)), "one | two");
  EXPECT_EQ(fitting_parts("one | two | three", " | ", fits(2)), "one");
}

TEST(PanelText, a_photograph_has_the_numbers_of_the_view_in_the_window) {
  Viewer viewer;
  viewer.version = 7;
  viewer.photograph.path = "/images/a.jpg";
  EXPECT_EQ(photograph_text(viewer), "photograph a.jpg");
  viewer.photograph.quality = PhotographQuality{7, 31.2, 0.9412, ""};
  EXPECT_EQ(photograph_text(viewer), "photograph a.jpg \u00b7 PSNR 31.20 dB, SSIM 0.941");
  ++viewer.version;
  EXPECT_EQ(photograph_text(viewer), "photograph a.jpg") << "of an earlier view";
}

// ---- heat maps ----------------------------------------------------------------------------------
TEST(PanelText, a_map_is_awaited_until_the_picture_shows_it) {
  test::DrivenScene driven(0);
  EXPECT_FALSE(awaited_map(driven.viewer));
  driven.press("H");
  EXPECT_EQ(awaited_map(driven.viewer), HeatQuantity::pairs);
  EXPECT_THAT(awaited_title(driven.viewer), HasSubstr("tile"));
  driven.apply([](Viewer& viewer) { viewer.shown.heatmap.emplace(); });
  EXPECT_FALSE(awaited_map(driven.viewer));
  EXPECT_EQ(awaited_title(driven.viewer), "");
  driven.press("Shift+H");
  EXPECT_EQ(awaited_map(driven.viewer), HeatQuantity::evaluated);
}

TEST(PanelText, a_heat_map_s_ticks_stand_at_their_values) {
  Viewer viewer;
  ShownFrame& shown = viewer.shown;
  shown.heatmap.emplace();
  shown.heatmap->values = {0, 1234, 2000};
  shown.map_scale = {500, 2000};
  const std::vector<BarTick> ticks = heat_legend(viewer).ticks;
  ASSERT_THAT(ticks, SizeIs(5));
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    EXPECT_FLOAT_EQ(ticks[i].at, 0.25f * static_cast<float>(i));
    EXPECT_THAT(ticks[i].text, HasSubstr(i == 0 ? "0" : i % 2 == 0 ? "000" : "500"));
  }
  EXPECT_EQ(heat_text(shown, *shown.heatmap, 1), "here: 1,234 pairs");
  EXPECT_THAT(heat_legend(viewer).title, Not(HasSubstr(" at ")));
  shown.divisor = 2;  // a reduced picture has fewer tiles
  EXPECT_THAT(heat_legend(viewer).title, EndsWith(" at 1/2"));
  EXPECT_EQ(heat_text(shown, *shown.heatmap, 1), "here: 1,234 pairs at 1/2");
  shown.divisor = 1;
}

TEST(PanelText, a_map_of_missed_contributions_names_their_alpha_and_error) {
  Viewer viewer;
  ShownFrame& shown = viewer.shown;
  shown.heatmap.emplace();
  shown.heatmap->quantity = HeatQuantity::missed;
  shown.heatmap->values = {0, 3};
  shown.missed.emplace();
  shown.missed->alphas = {0, 0.25f};
  shown.missed->errors = {0, 0.125f};
  EXPECT_EQ(heat_text(shown, *shown.heatmap, 0), "here: 0 contributions");
  EXPECT_EQ(heat_text(shown, *shown.heatmap, 1),
            "here: 3 contributions, alpha to 0.25, colour off by 0.125");
  EXPECT_EQ(heat_facts(viewer), "mode quadbox \u00b7 " + missed_sentence(*shown.missed));
}

TEST(PanelText, a_legend_of_depth_is_in_units_and_names_the_value_under_the_cursor) {
  ShownFrame shown;
  shown.values = ValueMap{Quantity::depth, 2, 1, {0, 1.23456f}, {1, 2, 0.5f}};
  const std::vector<BarTick> ticks = make_legend(*shown.values, "any").ticks;
  ASSERT_THAT(ticks, SizeIs(3));
  EXPECT_EQ(ticks[0].text, "1.0");
  EXPECT_EQ(ticks[1].text, "1.5");
  EXPECT_FLOAT_EQ(ticks[1].at, 0.5f);
  EXPECT_EQ(ticks[2].text, "2.0 units");
  EXPECT_EQ(value_text(shown, 0), "here: nothing");
  EXPECT_EQ(value_text(shown, 1), "here: 1.235 units");
  shown.values->quantity = Quantity::alpha;
  EXPECT_EQ(value_text(shown, 1), "here: 1.235");
  Viewer viewer;
  viewer.shown = shown;
  EXPECT_EQ(hud_caveat(viewer), "without colours: not a measurement");
}

// ---- the scene, cameras, the inspector ----------------------------------------------------------
TEST(PanelText, the_scene_s_facts_are_those_of_its_file) {
  Viewer viewer = known_viewer();
  EXPECT_EQ(scene_summary(viewer), "garden   5,834,784 Gaussians   cpu   640 x 480");
  Viewer streamed = known_viewer();
  streamed.scene->nodes = 27'234'724;
  EXPECT_EQ(scene_summary(streamed), "garden   27,234,724 nodes   cpu   640 x 480");
  const std::vector<Fact> facts = scene_facts_of(viewer);
  EXPECT_EQ(value_of(facts, "file"), "/data/garden.ply");
  EXPECT_EQ(value_of(facts, "Gaussians"), "5,834,784");
  EXPECT_EQ(value_of(facts, "size"), "1.4 GB");
  EXPECT_EQ(value_of(facts, "SH degree"), "3");
  EXPECT_EQ(value_of(facts, "extent"), "2.5 units, the longest side of its middle 90 %");
  EXPECT_THAT(value_of(facts, "cameras"), HasSubstr("none"));
  EXPECT_EQ(value_of(facts, "view"), "from -1, 2, -3.46");
  const double fov = 2 * std::atan(0.5 * 480 / viewer.camera.focal_px.y);
  EXPECT_EQ(std::stod(value_of(facts, "lens")), std::round(10 * glm::degrees(fov)) / 10);
}

TEST(PanelText, lists_count_cameras_from_0_and_keyframes_from_1) {
  Viewer viewer = known_viewer();
  viewer.scene->cameras = {test::front_camera(800, 600), test::front_camera(320, 240)};
  viewer.scene->cameras[1].name = "IMG_7";
  viewer.scene->photographs[1] = "/IMG_7.jpg";
  EXPECT_EQ(camera_label(*viewer.scene, 1), "1  IMG_7  320 x 240  photograph");
  EXPECT_THAT(camera_label(*viewer.scene, 0), HasSubstr("800 x 600"));
  EXPECT_EQ(value_of(scene_facts_of(viewer), "cameras"), "2, 1 with a photograph");
  viewer.keyframes = {{0, viewer.camera}, {1.25, viewer.camera}};
  EXPECT_EQ(keyframe_label(viewer, 1), "2  at 1.25 s");
}

TEST(PanelText, the_inspector_s_cells_are_the_contribution_s_numbers) {
  Contribution row;
  row.depth = 3.14159f;
  row.alpha = 0.5f;
  row.transmittance = 0.25f;
  row.weight = 0.125f;
  EXPECT_THAT(contribution_cells(row, false), ElementsAre("3.142", "0.5000", "0.2500", "0.1250"));
  EXPECT_THAT(contribution_cells(row, true), ElementsAre("3.142", "0.5000", "0.2500", "-"));
  PixelReport pixel;
  pixel.pixel = {40, 120};
  pixel.listed = 17;
  pixel.contributions.resize(5);
  EXPECT_EQ(inspected_pixel_text(pixel),
            "Pixel 40, 120: 5 of the 17 Gaussians of its tile are blended");
}

TEST(StateJson, holds_the_numbers_of_the_panels) {
  Viewer viewer = known_viewer();
  viewer.numbers = {viewer.view_version, {row_of_mode("quadbox", 0.9612, 1796352)}};
  const auto json = parse_json(state_json(viewer), "test");
  EXPECT_EQ(json["scene"], "garden");
  EXPECT_EQ(json["gaussians"], 5834784);
  EXPECT_EQ(json["modes"][4]["ms"], "0.961");
  EXPECT_EQ(json["modes"][4]["pairs"], "1,796,352");
  EXPECT_EQ(json["facts"]["render"], "~4.0 ms, ~250 FPS");
  EXPECT_TRUE(json["arrow"].is_null());
  EXPECT_EQ(json["first_views"], 0);
  EXPECT_EQ(json["interface_scale"], 1);
}

}  // namespace
}  // namespace qs
