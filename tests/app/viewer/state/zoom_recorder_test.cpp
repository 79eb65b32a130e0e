// SPDX-License-Identifier: MIT
//
// The zoom recorder without its jobs: the plan and its limits, the estimated time, the list of
// recordings, and the words of the panel.
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/session/session.h"
#include "app/support/driven_viewer.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/training_actions.h"
#include "app/viewer/state/zoom_actions.h"
#include "io/bytes/json_text.h"

namespace qs {
namespace {

using test::DrivenScene;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;
using namespace action;

BenchRow timed_row(const char* mode, double ms, std::uint64_t step = 0) {
  BenchRow row;
  row.mode = mode;
  row.pipeline = "fast";
  row.view = step;
  row.ms_median = row.ms_mean = ms;
  row.width = 640;
  row.height = 480;
  row.frames = 20;
  return row;
}

// ---- the plan -----------------------------------------------------------------------------------
TEST(ZoomPlan, values_are_clamped_to_their_ranges) {
  ZoomPlan plan;
  plan.closer = 0.5;
  plan.steps = -3;
  plan.frames = 1;
  plan.modes = {5, 99, 1, 5, 0, -1};
  plan.size = {100'000, 3};
  plan.pipeline = Pipeline::classic;
  const ZoomPlan least = clamped_plan(plan, Backend::cpu);
  EXPECT_EQ(least.closer, 1.1);
  EXPECT_EQ(least.steps, 2);
  EXPECT_EQ(least.frames, 20);
  EXPECT_THAT(least.modes, ElementsAre(1, 5));
  EXPECT_EQ(least.size, glm::ivec2(8192, 3));
  EXPECT_FALSE(least.pipeline) << "the CPU has one";
  EXPECT_EQ(clamped_plan(plan, Backend::cuda).pipeline, Pipeline::classic);
  plan.closer = 1e9;
  plan.steps = plan.frames = std::numeric_limits<int>::max();
  plan.modes = all_modes();
  plan.size = {0, 480};
  const ZoomPlan most = clamped_plan(plan, Backend::cuda);
  EXPECT_EQ(most.closer, 1000);
  EXPECT_EQ(most.steps, 200);
  EXPECT_EQ(most.frames, 1000);
  EXPECT_THAT(most.modes, IsEmpty()) << "all";
  EXPECT_EQ(most.size, glm::ivec2(0));
  plan.closer = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(clamped_plan(plan, Backend::cpu).closer, 20);
  EXPECT_EQ(clamped_plan(ZoomPlan(), Backend::cpu), ZoomPlan()) << "the defaults are in range";
  EXPECT_EQ(zoom_modes(ZoomPlan()), all_modes());
}

TEST(ZoomPlan, every_change_of_the_plan_is_clamped) {
  DrivenScene driven(1);
  ZoomPlan plan;
  plan.frames = 3;
  driven.apply(change_zoom_plan, plan);
  EXPECT_EQ(driven.viewer.zoom.plan.frames, 20);
  driven.apply(zoom_end_found, 1e6);
  EXPECT_EQ(driven.viewer.zoom.plan.closer, 1000);
}

TEST(ZoomPlan, the_start_is_the_view_of_the_window_unless_one_is_remembered) {
  DrivenScene driven(2);
  const auto start = [&] { return zoom_start(driven.viewer.zoom.plan, driven.viewer.camera); };
  EXPECT_EQ(start().view_from_world, driven.viewer.camera.view_from_world);
  EXPECT_EQ(glm::ivec2(start().width, start().height), glm::ivec2(640, 480));
  driven.apply(start_zoom_here);
  const Camera first = driven.viewer.camera;
  driven.apply(orbit, glm::dvec2(50, 0));
  EXPECT_EQ(start().view_from_world, first.view_from_world);
  driven.apply(choose_zoom, std::string("size=1280x720"));
  EXPECT_EQ(glm::ivec2(start().width, start().height), glm::ivec2(1280, 720));
  driven.apply(forget_zoom_start);
  EXPECT_EQ(start().view_from_world, driven.viewer.camera.view_from_world);
}

TEST(ZoomPlan, a_script_sets_its_parts_by_words) {
  DrivenScene driven(1);
  driven.apply(choose_zoom,
               std::string("steps=3 frames=40  closer=8 modes=exact,3dgs size=640x480"));
  const ZoomPlan plan = driven.viewer.zoom.plan;
  EXPECT_EQ(plan.steps, 3);
  EXPECT_EQ(plan.frames, 40);
  EXPECT_EQ(plan.closer, 8);
  EXPECT_THAT(plan.modes, ElementsAre(find_culler("3dgs"), find_culler("exact")));
  EXPECT_EQ(plan.size, glm::ivec2(640, 480));
  for (const char* wrong : {"steps", "steps=1", "steps=two", "frames=19", "closer=1", "modes=fast",
                            "modes=reference", "size=3", "speed=3"}) {
    driven.apply(choose_zoom, std::string(wrong));
    EXPECT_EQ(driven.viewer.zoom.plan, plan) << wrong;
    EXPECT_TRUE(driven.viewer.toasts.back().error) << wrong;
    EXPECT_THAT(driven.viewer.toasts.back().text, testing::StartsWith("zoom: ")) << wrong;
  }
  driven.apply(choose_zoom, std::string("size=window"));
  EXPECT_EQ(driven.viewer.zoom.plan.size, glm::ivec2(0));
}

// ---- the estimated time -------------------------------------------------------------------------
TEST(ZoomTime, is_that_of_the_modes_in_the_table_else_of_the_frame_in_the_window) {
  DrivenScene driven(1);
  driven.apply(choose_zoom, std::string("steps=10 modes=3dgs,quadbox"));
  EXPECT_FALSE(zoom_seconds(driven.viewer));
  EXPECT_EQ(zoom_plan_text(driven.viewer), "10 steps of 2 modes: time not known yet");
  driven.apply([](Viewer& viewer) {
    viewer.shown.camera = viewer.camera;
    viewer.shown.stats.frame_ms = 10;
  });
  // 20 timed frames, 3 of the warm-up and 1 that counts false positives.
  EXPECT_NEAR(*zoom_seconds(driven.viewer), 10 * 24 * (10 + 10) / 1000.0, 1e-9);
  driven.apply([](Viewer& viewer) { viewer.numbers.rows = {timed_row("3dgs", 40)}; });
  EXPECT_NEAR(*zoom_seconds(driven.viewer), 10 * 24 * (40 + 10) / 1000.0, 1e-9);
  EXPECT_EQ(zoom_plan_text(driven.viewer), "10 steps of 2 modes: about 15 s");
  driven.apply(choose_zoom, std::string("size=1280x960"));
  EXPECT_NEAR(*zoom_seconds(driven.viewer), 4 * 10 * 24 * (40 + 10) / 1000.0, 1e-9);
  driven.apply([](Viewer& viewer) { viewer.shown.divisor = 2; });  // a quarter of the pixels
  EXPECT_NEAR(*zoom_seconds(driven.viewer), 4 * 10 * 24 * (40 + 40) / 1000.0, 1e-9);
  EXPECT_FALSE(zoom_seconds(Viewer())) << "no window yet";
}

TEST(ZoomTime, is_rounded_up_to_words) {
  EXPECT_EQ(about_text(0), "less than 1 s");
  EXPECT_EQ(about_text(1), "about 1 s");
  EXPECT_EQ(about_text(9.1), "about 10 s");
  EXPECT_EQ(about_text(37), "about 40 s");
  EXPECT_EQ(about_text(55), "about 55 s");
  EXPECT_EQ(about_text(56), "about 1 min");
  EXPECT_EQ(about_text(150), "about 3 min");
  EXPECT_EQ(about_text(4000), "about 2 h");
}

TEST(ZoomTime, that_is_left_follows_the_steps_so_far) {
  DrivenScene driven(1);
  ZoomRecord record;
  record.steps = 5;
  record.modes = {1, 5};
  EXPECT_FALSE(zoom_seconds_left(driven.viewer.zoom));
  driven.apply(zoom_began, record);
  EXPECT_EQ(zoom_status(driven.viewer.zoom), "step 0 of 5");
  driven.apply(zoom_stepped, std::vector<BenchRow>{timed_row("3dgs", 60), timed_row("adr", 40)});
  EXPECT_NEAR(*zoom_seconds_left(driven.viewer.zoom), 4 * 23 * 0.1, 1e-9);
  EXPECT_EQ(zoom_status(driven.viewer.zoom), "step 1 of 5, about 10 s left");
}

// ---- the recordings -----------------------------------------------------------------------------
ZoomRecord found_record(const char* folder) {
  ZoomRecord record;
  record.folder = folder;
  record.scene = "garden";
  record.machine = "some CPU";
  record.pipeline = "cpu";
  record.width = 640;
  record.height = 480;
  record.steps = 2;
  record.modes = {1};
  record.rows = {timed_row("3dgs", 4), timed_row("3dgs", 5, 1)};
  return record;
}

TEST(ZoomRecorder, rows_are_collected_until_the_end_and_the_next_recording_is_another) {
  DrivenScene driven(1);
  const ZoomRecorder& zoom = driven.viewer.zoom;
  ZoomRecord record;
  record.steps = 3;
  record.modes = {1, 5};
  driven.apply(zoom_stepped, std::vector<BenchRow>(1));  // of no recording
  EXPECT_THAT(zoom.records, IsEmpty());
  driven.apply(zoom_began, record);
  EXPECT_TRUE(zoom.running);
  for (int step = 0; step < 2; ++step) driven.apply(zoom_stepped, std::vector<BenchRow>(2));
  ASSERT_NE(shown_zoom(zoom), nullptr);
  EXPECT_THAT(shown_zoom(zoom)->rows, SizeIs(4));
  const int version = driven.viewer.version;
  driven.apply(zoom_ended, std::filesystem::path(), false);
  EXPECT_FALSE(zoom.running);
  EXPECT_EQ(driven.viewer.version, version + 1) << "the window shows the last step";
  EXPECT_EQ(zoom_status(zoom), "stopped after 2 of 3 steps, not saved");
  driven.apply(zoom_began, record);
  EXPECT_THAT(zoom.records, SizeIs(1)) << "the stopped one is gone";
  driven.apply(zoom_stepped, std::vector<BenchRow>(2));
  driven.apply(zoom_ended, std::filesystem::path("zoom/garden_0001"), true);
  EXPECT_EQ(zoom_status(zoom), "saved in zoom/garden_0001");
  driven.apply(zoom_began, record);
  EXPECT_THAT(zoom.records, SizeIs(2));
  driven.apply(zoom_ended, std::filesystem::path(), false);
  EXPECT_THAT(zoom.records, SizeIs(1)) << "nothing was measured";
  EXPECT_EQ(shown_zoom(zoom), nullptr);
}

TEST(ZoomRecorder, earlier_recordings_come_first_and_the_choice_of_the_chart_stays) {
  DrivenScene driven(1);
  const ZoomRecorder& zoom = driven.viewer.zoom;
  driven.apply(zoom_began, ZoomRecord());
  driven.apply(zoom_stepped, std::vector<BenchRow>(2));
  driven.apply(zoom_ended, std::filesystem::path("zoom/c"), true);
  driven.apply(zooms_found, std::vector<ZoomRecord>{found_record("zoom/a"), found_record("zoom/b"),
                                                    found_record("zoom/c")});
  ASSERT_THAT(zoom.records, SizeIs(3));
  EXPECT_EQ(zoom.records[0].folder, "zoom/a");
  EXPECT_EQ(shown_zoom(zoom)->folder, "zoom/c");
  driven.apply(lay_zoom_beneath, std::size_t{2});
  EXPECT_FALSE(zoom.beneath) << "it is shown already";
  driven.apply(lay_zoom_beneath, std::size_t{1});
  EXPECT_EQ(zoom_beneath(zoom)->folder, "zoom/b");
  driven.apply(show_zoom, std::size_t{1});
  EXPECT_FALSE(zoom.beneath);
  EXPECT_EQ(shown_zoom(zoom)->folder, "zoom/b");
  driven.apply(lay_zoom_beneath, std::size_t{0});
  driven.apply(lay_zoom_beneath, std::size_t{0});
  EXPECT_FALSE(zoom.beneath);
  driven.apply(show_zoom, std::size_t{7});
  driven.apply(lay_zoom_beneath, std::size_t{7});
  EXPECT_EQ(zoom.shown, 1u);
  EXPECT_FALSE(zoom.beneath);
  driven.apply(zoom_began, ZoomRecord());
  driven.apply(show_zoom, std::size_t{0});
  EXPECT_EQ(zoom.shown, 3u) << "the running one stays in the chart";
}

TEST(ZoomRecorder, labels_and_reliability_are_told) {
  ZoomRecord record = found_record("out/zoom/garden_0001");
  EXPECT_EQ(zoom_label(record), "garden_0001 \u00b7 cpu \u00b7 640 x 480 \u00b7 some CPU");
  EXPECT_EQ(zoom_trust_text(record), "medians of 20 frames, bars: the middle half of them");
  record.rows[1].ms_spread = 3;
  EXPECT_EQ(
      zoom_trust_text(record),
      "medians of 20 frames, bars: the middle half of them; noisy steps (rings): 3dgs 1 of 2");
  record.rows[0].frames = 1;
  EXPECT_EQ(zoom_trust_text(record), "single frames; noisy steps (rings): 3dgs 1 of 2");
  record.rows[0].altered = "splat scale 0.5";
  EXPECT_EQ(zoom_label(record),
            "garden_0001 \u00b7 cpu \u00b7 640 x 480 \u00b7 some CPU \u00b7 splat scale 0.5");
  record.folder.clear();
  EXPECT_EQ(zoom_title(record), "garden, not saved");
}

TEST(ZoomRecorder, the_figure_s_path_is_copied_and_the_folder_opened) {
  DrivenScene driven(1);
  driven.apply(copy_zoom_figure);
  driven.apply(open_zoom_folder);
  EXPECT_THAT(driven.opened_outside, IsEmpty());
  EXPECT_EQ(driven.viewer.toasts.back().text, "this zoom is not saved");
  const ZoomRecord record = found_record("./zoom/a");
  driven.apply(zooms_found, std::vector<ZoomRecord>{record});
  driven.apply(show_zoom, std::size_t{0});
  driven.apply(copy_zoom_figure);
  EXPECT_EQ(driven.text, "");
  EXPECT_THAT(driven.viewer.toasts.back().text, HasSubstr("the figures are not drawn"));
  driven.apply([](Viewer& viewer) { viewer.zoom.records[0].has_figures = true; });
  driven.apply(copy_zoom_figure);
  EXPECT_TRUE(std::filesystem::path(driven.text).is_absolute());
  EXPECT_THAT(driven.text, EndsWith("zoom/a/zoom_fps.png"));
  EXPECT_THAT(driven.text, Not(HasSubstr("/./")));
  EXPECT_THAT(driven.viewer.toasts.back().text, HasSubstr(driven.text));
  driven.apply(show_zoom_quantity, ZoomQuantity::pairs);
  driven.apply(copy_zoom_figure);
  EXPECT_THAT(driven.text, EndsWith("zoom/a/zoom_pairs.png"));
  driven.apply(open_zoom_folder);
  ASSERT_THAT(driven.opened_outside, SizeIs(1));
  EXPECT_EQ(driven.opened_outside[0], std::filesystem::absolute("zoom/a"));
}

TEST(ZoomRecorder, the_figure_is_copied_as_a_picture_where_a_program_can) {
  DrivenScene driven(1);
  ZoomRecord record = found_record("./zoom/a");
  record.has_figures = true;
  driven.apply(zooms_found, std::vector<ZoomRecord>{record});
  driven.apply(show_zoom, std::size_t{0});
  driven.copies_pictures = true;
  driven.apply(copy_zoom_figure);
  EXPECT_EQ(driven.text, "") << "no path";
  ASSERT_THAT(driven.copied, SizeIs(1));
  EXPECT_THAT(driven.copied[0].string(), EndsWith("zoom/a/zoom_fps.png"));
  EXPECT_EQ(driven.viewer.toasts.back().text, "the figure is on the clipboard");
}

TEST(ZoomRecorder, nothing_is_recorded_while_a_model_is_trained) {
  DrivenScene driven(1);
  driven.apply([](Viewer& viewer) { viewer.training.emplace(); });
  ASSERT_TRUE(is_training(driven.viewer));
  driven.press("Shift+Z");
  EXPECT_THAT(driven.jobs, IsEmpty());
  EXPECT_THAT(driven.viewer.toasts.back().text, HasSubstr("training"));
}

TEST(ZoomRecorder, its_state_has_the_numbers_of_the_chart) {
  DrivenScene driven(1);
  nlohmann::ordered_json json = zoom_json(driven.viewer);
  EXPECT_EQ(json["frames"], 0);
  EXPECT_EQ(json["folder"], "");
  EXPECT_EQ(json["chart"]["curves"].size(), 0u);
  EXPECT_EQ(json["plan"]["frames"], 20);
  EXPECT_EQ(json["plan"]["modes"].size(), static_cast<std::size_t>(culler_count()));
  driven.apply(zooms_found, std::vector<ZoomRecord>{found_record("zoom/a")});
  driven.apply(show_zoom, std::size_t{0});
  json = zoom_json(driven.viewer);
  EXPECT_EQ(json["frames"], 20);
  EXPECT_EQ(json["rows"], 2);
  EXPECT_EQ(json["recordings"].size(), 1u);
  EXPECT_EQ(json["chart"]["curves"][0]["mode"], "3dgs");
  EXPECT_EQ(json["chart"]["curves"][0]["points"][0][1], 250);
}

TEST(RunningText, is_in_the_line_and_the_title_with_the_time_left) {
  DrivenScene driven(1);
  EXPECT_EQ(running_text(driven.viewer), "");
  EXPECT_EQ(window_title(driven.viewer), "garden - quadsplat");
  EXPECT_EQ(window_title(Viewer()), "quadsplat");
  driven.apply(tick, Turn{10}, 0.0);
  driven.apply(show_progress, Loading{"/a.mp4", kFilming, 0.01f});
  EXPECT_EQ(running_text(driven.viewer), "filming, 1 %");
  driven.apply(tick, Turn{20}, 0.0);
  driven.apply(show_progress, Loading{"/a.mp4", kFilming, 0.25f});
  EXPECT_EQ(running_text(driven.viewer), "filming, 25 %, about 30 s left");
  EXPECT_EQ(status_line(driven.viewer).note, "filming, 25 %, about 30 s left   Esc: cancel");
  EXPECT_EQ(window_title(driven.viewer), "filming, 25 %, about 30 s left - garden - quadsplat");
  driven.apply(show_progress, Loading{"/a.ply", kBenching, 0.5f});
  EXPECT_EQ(running_text(driven.viewer), "benching, 50 %, less than 1 s left") << "it begins again";
  driven.apply(end_progress);
  ZoomRecord record;
  record.steps = 12;
  record.modes = {1};
  driven.apply(zoom_began, record);
  driven.apply(zoom_stepped, std::vector<BenchRow>(5, timed_row("3dgs", 2)));
  EXPECT_THAT(running_text(driven.viewer), testing::StartsWith("recording a zoom, step 5 of 12"));
  driven.apply(cancel_running);
  EXPECT_EQ(driven.stopped, 1);
}

}  // namespace
}  // namespace qs
