// SPDX-License-Identifier: MIT
//
// The FPS of all modes in flight, by frames beside the pictures in the window, and the pairs of
// reduced frames.
#include "app/viewer/state/samples.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/viewer/state/actions.h"
#include "app/viewer/state/hud_text.h"
#include "support/recording_host.h"

namespace qs {
namespace {

using testing::HasSubstr;

ShownFrame frame_of(const Viewer& viewer, float ms, std::uint64_t pairs, int divisor) {
  ShownFrame frame;
  frame.mode = viewer.mode();
  frame.view_version = viewer.view_version;
  frame.version = viewer.version;
  frame.divisor = divisor;
  frame.stats.frame_ms = ms;
  frame.stats.tile_pairs = pairs;
  return frame;
}

HudRow row_of(const Viewer& viewer, const char* mode) {
  return hud_rows(viewer)[static_cast<std::size_t>(find_culler(mode) - 1)];
}

TEST(Samples, have_the_two_digits_that_one_frame_gives) {
  EXPECT_EQ(rough(312.5), "310");
  EXPECT_EQ(rough(1234), "1200");
  EXPECT_EQ(rough(14.04), "14");
  EXPECT_EQ(rough(9.96), "10");
  EXPECT_EQ(rough(5.24), "5.2");
  EXPECT_EQ(rough(0.834), "0.83");
  EXPECT_EQ(rough(0.0123), "0.012");
  EXPECT_EQ(rough(0), "0");
  EXPECT_EQ(live_text({52.4, 0}), "~52");
  EXPECT_EQ(live_text({52.4, 1}), "~52");
  EXPECT_EQ(live_text({52.4, 4.2}), "~52 (4 s)");
}

// A flight of quadbox at 1/2 of 640 x 480, with a new view for every picture.
class LiveRates : public testing::Test {
 protected:
  LiveRates() {
    viewer_.settings.mode = find_culler("quadbox");
    viewer_.camera.width = 640;
    viewer_.camera.height = 480;
  }

  void show(double ms, int divisor = 2) {
    viewer_.now += 0.02;
    viewer_.last_motion = viewer_.now;
    action::view_changed(viewer_);
    ShownFrame frame = frame_of(viewer_, static_cast<float>(ms), 1000, divisor);
    frame.camera = viewer_.camera;
    action::frame_shown(viewer_, frame);
  }

  // A frame of another mode that took `ms` beside a picture that took `shown_ms`.
  void pair(const char* mode, double shown_ms, double ms, int divisor = 2) {
    PairedFrame pair;
    pair.variant = {find_culler(mode), viewer_.settings.pipeline, viewer_.backend};
    pair.shown = viewer_.mode();
    pair.speed = shown_ms / ms;
    pair.size = glm::ivec2(640, 480) / divisor;
    pair.view_version = viewer_.view_version;
    action::frame_paired(viewer_, pair);
  }

  std::string fps(const char* mode) const { return row_of(viewer_, mode).fps.text; }

  Viewer viewer_;
};

TEST_F(LiveRates, are_those_of_the_last_second_times_the_median_ratio_of_five_pairs) {
  show(20);
  EXPECT_EQ(fps("quadbox"), "~50");
  for (const double ms : {40.0, 40.0, 400.0, 10.0}) pair("3dgs", 20, ms);
  EXPECT_EQ(fps("3dgs"), "-") << "four pairs";
  EXPECT_EQ(trust_text(viewer_, find_culler("3dgs")), "not measured yet");
  pair("3dgs", 30, 60);
  EXPECT_EQ(fps("3dgs"), "~25");
  EXPECT_THAT(trust_text(viewer_, find_culler("3dgs")), HasSubstr("~ is of at least 5 frames"));
  // The view becomes slower: all rows follow, by the same ratios.
  for (int i = 0; i < 60; ++i) show(40);
  EXPECT_EQ(fps("quadbox"), "~25");
  EXPECT_EQ(fps("3dgs"), "~13 (1 s)");
  // The last eight.
  for (int i = 0; i < 5; ++i) pair("3dgs", 40, 40);
  EXPECT_EQ(fps("3dgs"), "~25");
}

TEST_F(LiveRates, leave_nothing_of_an_earlier_view_in_a_row) {
  BenchRow measured;
  measured.mode = "3dgs";
  measured.ms_median = 1000 / (measured.fps_median = 48);
  measured.pairs = 5000;
  viewer_.numbers = {viewer_.view_version, {measured}};
  EXPECT_EQ(row_of(viewer_, "3dgs").pairs.text, "5,000");
  show(20);
  const HudRow row = row_of(viewer_, "3dgs");
  for (const HudCell& cell : {row.fps, row.ms, row.ratio, row.pairs, row.per_visible, row.unused}) {
    EXPECT_EQ(cell.text, "-");
    EXPECT_EQ(cell.value, 0);
  }
  for (int i = 0; i < 5; ++i) pair("3dgs", 20, 30);
  EXPECT_EQ(row_of(viewer_, "3dgs").ms.text, "~30");
  EXPECT_EQ(row_of(viewer_, "3dgs").ratio.text, "~1.0x");
  EXPECT_EQ(row_of(viewer_, "quadbox").ratio.text, "~1.5x");
  EXPECT_THAT(table_caption(viewer_), HasSubstr("640 x 480 at 1/2"));
}

TEST_F(LiveRates, and_pairs_of_the_line_are_the_numbers_of_the_row) {
  viewer_.scene.emplace();
  viewer_.panels.hud = true;
  show(20);
  viewer_.counts = {
      viewer_.view_version, {640, 480}, viewer_.frames, std::vector<ModePairs>(6, {5000, 10})};
  for (const char* pairs : {"5,000", "~5,000"}) {
    EXPECT_EQ(row_of(viewer_, "quadbox").pairs.text, pairs);
    const std::string line = status_line(viewer_).numbers;
    EXPECT_THAT(line, HasSubstr(fmt::format("~50 FPS at 1/2  \u00b7  {} pairs  ", pairs)));
    EXPECT_THAT(line, HasSubstr("  10 of "));
    show(20);  // a picture that does not count
  }
}

TEST_F(LiveRates, compare_frames_of_one_size) {
  show(20);
  for (int i = 0; i < 5; ++i) pair("3dgs", 20, 40);
  show(50, 1);
  EXPECT_EQ(fps("quadbox"), "~20");
  EXPECT_EQ(fps("3dgs"), "-") << "no pair of this size";
  for (int i = 0; i < 5; ++i) pair("3dgs", 50, 500, 1);
  EXPECT_EQ(fps("3dgs"), "~2.0");
  show(20);
  EXPECT_EQ(fps("3dgs"), "~25") << "the pairs of the other size are kept";
}

TEST_F(LiveRates, outlive_a_switch_of_the_mode) {
  show(20);
  for (int i = 0; i < 5; ++i) {
    pair("3dgs", 20, 40);
    pair("exact", 20, 10);
  }
  viewer_.settings.mode = find_culler("3dgs");
  show(80);
  EXPECT_EQ(fps("3dgs"), "~13");
  EXPECT_EQ(fps("quadbox"), "~25");
  EXPECT_EQ(fps("exact"), "~50");
  viewer_.mode_switch = {find_culler("quadbox"), find_culler("3dgs"), viewer_.now};
  viewer_.counts = {
      viewer_.view_version, {640, 480}, viewer_.frames, std::vector<ModePairs>(6, {5000, 10})};
  EXPECT_EQ(switch_text(viewer_), "FPS ~25 -> ~13, pairs 5,000 -> 5,000");
}

TEST_F(LiveRates, of_a_switch_need_one_pair) {
  show(20);
  viewer_.settings.mode = find_culler("3dgs");
  viewer_.mode_switch = {find_culler("quadbox"), find_culler("3dgs"), viewer_.now};
  show(40);
  viewer_.counts = {
      viewer_.view_version, {640, 480}, viewer_.frames, std::vector<ModePairs>(6, {5000, 10})};
  EXPECT_EQ(switch_text(viewer_), "FPS - -> ~25, pairs 5,000 -> 5,000");
  pair("quadbox", 40, 20);
  EXPECT_EQ(switch_text(viewer_), "FPS ~50 -> ~25, pairs 5,000 -> 5,000");
  EXPECT_EQ(fps("quadbox"), "-") << "a row needs five";
}

TEST_F(LiveRates, stand_beside_counts_of_the_same_size_alone) {
  viewer_.counts = {
      viewer_.view_version, {640, 480}, viewer_.frames, std::vector<ModePairs>(6, {5000, 10})};
  EXPECT_TRUE(live_pairs(viewer_, find_culler("adr")));
  viewer_.counts.size = {640, 960};  // before a panel was opened
  EXPECT_FALSE(live_pairs(viewer_, find_culler("adr")));
}

TEST_F(LiveRates, that_are_not_known_are_left_out_of_a_switch) {
  viewer_.settings.mode = find_culler("3dgs");
  viewer_.mode_switch = {find_culler("quadbox"), find_culler("3dgs"), viewer_.now};
  viewer_.counts = {
      viewer_.view_version, {640, 480}, viewer_.frames, std::vector<ModePairs>(6, {5000, 10})};
  EXPECT_EQ(switch_text(viewer_), "pairs 5,000 -> 5,000");
}

TEST_F(LiveRates, are_not_shifted_by_one_bad_pair_with_the_next_mode) {
  show(20);
  for (int i = 0; i < 5; ++i) pair("exact", 20, 10);
  pair("3dgs", 20, 400);
  viewer_.settings.mode = find_culler("3dgs");
  show(40);
  EXPECT_EQ(fps("3dgs"), "~25");
  EXPECT_EQ(fps("exact"), "-");
}

TEST_F(LiveRates, of_a_view_at_rest_need_one_pair) {
  show(20, 1);
  pair("3dgs", 20, 40, 1);
  EXPECT_EQ(fps("3dgs"), "-");
  viewer_.now += 5;
  EXPECT_EQ(fps("3dgs"), "~25");
}

TEST_F(LiveRates, are_of_the_pipeline_in_use_and_of_the_picture_in_the_window) {
  show(20);
  EXPECT_EQ(fps("quadbox"), "~50");
  const Pipeline used = std::exchange(
      viewer_.settings.pipeline,
      viewer_.settings.pipeline == Pipeline::fast ? Pipeline::classic : Pipeline::fast);
  EXPECT_EQ(fps("quadbox"), "-");
  viewer_.settings.pipeline = used;
  EXPECT_EQ(fps("quadbox"), "~50");
  // A picture with a map takes longer, and its view has changed.
  action::view_changed(viewer_);
  ShownFrame frame = frame_of(viewer_, 30, 1000, 2);
  frame.heatmap.emplace();
  action::frame_shown(viewer_, frame);
  EXPECT_EQ(fps("quadbox"), "-");
}

TEST(LiveTimes, come_only_from_frames_that_draw_the_mode_alone) {
  Viewer viewer;
  ShownFrame frame = frame_of(viewer, 20, 1000, 1);
  frame.heatmap.emplace();
  action::frame_shown(viewer, frame);
  frame.heatmap.reset();
  frame.other.emplace();
  action::frame_shown(viewer, frame);
  frame.other.reset();
  frame.grid.emplace();
  action::frame_shown(viewer, frame);
  EXPECT_TRUE(viewer.live.shown.empty());
}

TEST(FullSizePairs, of_a_reduced_frame_are_estimated_from_views_that_were_drawn_in_both_sizes) {
  Viewer viewer;
  const auto show = [&](std::uint64_t pairs, int divisor) {
    action::frame_shown(viewer, frame_of(viewer, 20, pairs, divisor));
    return full_size_pairs(viewer);
  };
  EXPECT_FALSE(show(1000, 2)) << "nothing is known yet";
  EXPECT_THAT(status_line(viewer).numbers, HasSubstr("1,000 pairs at 1/2"));
  EXPECT_EQ(show(3750, 1)->pairs, 3750u);
  EXPECT_TRUE(full_size_pairs(viewer)->exact);
  action::view_changed(viewer);
  const auto estimate = show(2004, 2);
  ASSERT_TRUE(estimate);
  EXPECT_EQ(estimate->pairs, 7500u);  // 3.75 times 2,004, two digits
  EXPECT_FALSE(estimate->exact);
  EXPECT_THAT(status_line(viewer).numbers, HasSubstr("~7,500 pairs"));
  EXPECT_FALSE(show(900, 3)) << "another size";
}

TEST(FullSizePairs, are_estimated_from_the_first_reduced_frame_of_a_motion) {
  Viewer viewer;
  const auto show = [&](std::uint64_t pairs, std::uint32_t visible, int divisor) {
    action::view_changed(viewer);
    ShownFrame frame = frame_of(viewer, 20, pairs, divisor);
    frame.stats.visible = visible;
    action::frame_shown(viewer, frame);
    return full_size_pairs(viewer);
  };
  show(6000, 100, 1);
  EXPECT_EQ(show(1500, 95, 2)->pairs, 6000u);
  EXPECT_EQ(show(1000, 90, 2)->pairs, 4000u);
  EXPECT_EQ(show(500, 92, 4)->pairs, 4000u);
  show(6000, 100, 1);
  EXPECT_FALSE(show(1000, 60, 3)) << "a jump to another view";
}

TEST(FullSizePairs, of_a_reduced_frame_that_counted_are_exact) {
  Viewer viewer;
  ShownFrame frame = frame_of(viewer, 20, 1000, 2);
  for (unsigned i = 0; i < static_cast<unsigned>(culler_count()); ++i)
    frame.mode_pairs.push_back({4000 + i, 10});
  frame.counted_size = {640, 480};
  viewer.camera.width = 640;
  viewer.camera.height = 480;
  action::frame_shown(viewer, frame);
  ASSERT_TRUE(full_size_pairs(viewer));
  EXPECT_EQ(full_size_pairs(viewer)->pairs, 3999u + static_cast<unsigned>(viewer.mode()));
  EXPECT_TRUE(full_size_pairs(viewer)->exact);
  viewer.camera.width = 832;  // the count is of another size than the picture
  EXPECT_FALSE(full_size_pairs(viewer));
}

TEST(LiveTimes, are_forgotten_with_their_scene) {
  Viewer viewer;
  test::RecordingHost host;
  OpenedScene opened{};
  opened.facts.path = "/data/a.ply";
  action::scene_opened(viewer, host, opened);
  action::frame_shown(viewer, frame_of(viewer, 20, 1000, 2));
  action::frame_shown(viewer, frame_of(viewer, 20, 3000, 1));
  EXPECT_FALSE(viewer.live.shown.empty());
  opened.facts.path = "/data/b.ply";
  action::scene_opened(viewer, host, opened);
  EXPECT_TRUE(viewer.live.shown.empty());
  EXPECT_EQ(viewer.pair_growth.factors.size(), 1u);
}

}  // namespace
}  // namespace qs
