// SPDX-License-Identifier: MIT
//
// The times of single frames in the table of modes, and the pairs of reduced frames.
#include "app/viewer/state/samples.h"

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
  ModeSample sample;
  sample.frame_ms = 20;
  EXPECT_EQ(sample_text(sample), "~50");
  sample.divisor = 3;
  EXPECT_EQ(sample_text(sample), "~50 at 1/3");
}

TEST(Samples, of_frames_in_the_window_stand_in_the_table_until_the_modes_are_measured) {
  Viewer viewer;
  EXPECT_EQ(row_of(viewer, "quadbox").fps.text, "-");
  viewer.settings.mode = find_culler("quadbox");
  action::frame_shown(viewer, frame_of(viewer, 20, 1000, 2));
  EXPECT_EQ(row_of(viewer, "quadbox").fps.text, "~50 at 1/2");
  EXPECT_TRUE(row_of(viewer, "quadbox").fps_sampled);
  EXPECT_EQ(row_of(viewer, "quadbox").fps.value, 50);
  EXPECT_EQ(row_of(viewer, "3dgs").fps.text, "-");
  EXPECT_THAT(hud_status(viewer), HasSubstr("~ of single frames"));
  BenchRow measured;
  measured.mode = "quadbox";
  measured.fps_median = 48;
  measured.ms_median = 1000 / 48.0;
  viewer.numbers = {viewer.view_version, {measured}};
  EXPECT_EQ(row_of(viewer, "quadbox").fps.text, "48.0");
  EXPECT_FALSE(row_of(viewer, "quadbox").fps_sampled);
}

TEST(Samples, in_motion_replace_old_numbers_whose_bars_would_not_compare) {
  Viewer viewer;
  std::vector<BenchRow> rows(2);
  rows[0].mode = "3dgs";
  rows[1].mode = "quadbox";
  for (BenchRow& row : rows) row.ms_median = 1000 / (row.fps_median = 48);
  viewer.numbers = {viewer.view_version, rows};
  action::view_changed(viewer);
  ModeSample sample;
  sample.variant = {find_culler("quadbox"), viewer.settings.pipeline, viewer.backend};
  sample.frame_ms = 10;
  sample.view_version = viewer.view_version;
  action::mode_sampled(viewer, sample);
  EXPECT_EQ(row_of(viewer, "quadbox").fps.text, "~100");
  EXPECT_EQ(row_of(viewer, "3dgs").fps.text, "48.0");
  EXPECT_EQ(row_of(viewer, "3dgs").fps.value, 0);
}

TEST(Samples, are_of_the_pipeline_in_use_and_not_too_old) {
  Viewer viewer;
  const auto sampled = [&] { return sample_of(viewer, viewer.mode()) != nullptr; };
  action::frame_shown(viewer, frame_of(viewer, 20, 1000, 1));
  EXPECT_TRUE(sampled());
  const Pipeline used = std::exchange(
      viewer.settings.pipeline,
      viewer.settings.pipeline == Pipeline::fast ? Pipeline::classic : Pipeline::fast);
  EXPECT_FALSE(sampled());
  viewer.settings.pipeline = used;
  viewer.frames += kMostFramesOfSample;
  EXPECT_TRUE(sampled());
  ++viewer.frames;
  EXPECT_TRUE(sampled()) << "the view is the same";
  ++viewer.view_version;
  EXPECT_FALSE(sampled());
}

TEST(Samples, come_only_from_frames_that_draw_the_mode_alone) {
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
  EXPECT_TRUE(viewer.samples.empty());
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
  action::frame_shown(viewer, frame);
  ASSERT_TRUE(full_size_pairs(viewer));
  EXPECT_EQ(full_size_pairs(viewer)->pairs, 3999u + static_cast<unsigned>(viewer.mode()));
  EXPECT_TRUE(full_size_pairs(viewer)->exact);
  viewer.bare_size = {1280, 720};  // the count is of another size than the picture
  viewer.camera.width = 832;
  viewer.camera.height = 720;
  EXPECT_FALSE(full_size_pairs(viewer));
}

TEST(Samples, are_forgotten_with_their_scene) {
  Viewer viewer;
  test::RecordingHost host;
  OpenedScene opened{};
  opened.facts.path = "/data/a.ply";
  action::scene_opened(viewer, host, opened);
  action::frame_shown(viewer, frame_of(viewer, 20, 1000, 2));
  action::frame_shown(viewer, frame_of(viewer, 20, 3000, 1));
  EXPECT_FALSE(viewer.samples.empty());
  opened.facts.path = "/data/b.ply";
  action::scene_opened(viewer, host, opened);
  EXPECT_TRUE(viewer.samples.empty());
  EXPECT_EQ(viewer.pair_growth.factors.size(), 1u);
}

}  // namespace
}  // namespace qs
