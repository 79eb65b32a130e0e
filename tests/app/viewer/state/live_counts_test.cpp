// SPDX-License-Identifier: MIT
//
// The counts of all modes that the table shows while the camera moves.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/viewer/state/actions.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/samples.h"
#include "io/bytes/json_text.h"
#include "support/recording_host.h"

namespace qs {
namespace {

/// A frame of a view, whose counts are 100, 101, .. pairs and 10, 11, .. Gaussians.
ShownFrame frame_of(int view_version, bool counts) {
  ShownFrame frame;
  frame.view_version = view_version;
  for (unsigned i = 0; counts && i < static_cast<unsigned>(culler_count()); ++i)
    frame.mode_pairs.push_back({100 + i, 10 + i});
  return frame;
}

TEST(LiveCounts, of_a_frame_that_counted_are_exact_also_in_a_reduced_frame) {
  Viewer viewer;
  EXPECT_FALSE(live_pairs(viewer, 1));
  ShownFrame frame = frame_of(3, true);
  frame.divisor = 3;
  action::frame_shown(viewer, frame);
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const std::optional<LiveCount> live = live_pairs(viewer, mode);
    ASSERT_TRUE(live);
    EXPECT_EQ(live->tile_pairs, 99u + static_cast<unsigned>(mode));
    EXPECT_EQ(live->visible, 9u + static_cast<unsigned>(mode));
    EXPECT_EQ(live->frames_ago, 0);
  }
  for (const CullMode mode : {-1, kReferenceMode, culler_count() + 1, mode_count()})
    EXPECT_FALSE(live_pairs(viewer, mode)) << mode;
}

TEST(LiveCounts, tell_how_many_frames_of_other_views_came_after_them) {
  Viewer viewer;
  action::frame_shown(viewer, frame_of(3, true));
  action::frame_shown(viewer, frame_of(3, false));  // another mode of the same view
  EXPECT_EQ(live_pairs(viewer, 1)->frames_ago, 0);
  action::frame_shown(viewer, frame_of(4, false));
  EXPECT_EQ(live_pairs(viewer, 1)->frames_ago, 2);
  while (viewer.frames <= kMostFramesAgo) action::frame_shown(viewer, frame_of(5, false));
  EXPECT_EQ(live_pairs(viewer, 1)->frames_ago, kMostFramesAgo);
  action::frame_shown(viewer, frame_of(6, false));
  EXPECT_FALSE(live_pairs(viewer, 1)) << "too old";
  action::frame_shown(viewer, frame_of(7, true));
  EXPECT_EQ(live_pairs(viewer, 1)->frames_ago, 0);
}

TEST(LiveCounts, are_forgotten_with_their_scene_but_not_when_it_is_replaced_by_a_newer_model) {
  Viewer viewer;
  test::RecordingHost host;
  OpenedScene opened{};
  opened.facts.path = "/data/a.ply";
  action::scene_opened(viewer, host, opened);
  ShownFrame frame = frame_of(viewer.view_version, true);
  const Camera counted = counted_camera(viewer);
  frame.counted_size = {counted.width + 1, counted.height};
  action::frame_shown(viewer, frame);
  EXPECT_FALSE(counts_are_current(viewer)) << "another size";
  --frame.counted_size.x;
  action::frame_shown(viewer, frame);
  EXPECT_TRUE(counts_are_current(viewer));
  action::scene_opened(viewer, host, opened);
  EXPECT_FALSE(counts_are_current(viewer));
  EXPECT_TRUE(live_pairs(viewer, 1));
  opened.facts.path = "/data/b.ply";
  action::scene_opened(viewer, host, opened);
  EXPECT_FALSE(live_pairs(viewer, 1));
}

TEST(LiveCounts, are_in_the_state_of_the_window) {
  Viewer viewer;
  viewer.scene.emplace();
  const auto modes = [&] { return parse_json(state_json(viewer), "state")["modes"]; };
  EXPECT_TRUE(modes().at(0)["live_pairs"].is_null());
  action::frame_shown(viewer, frame_of(1, true));
  EXPECT_EQ(modes().at(0)["live_pairs"], 100);
  EXPECT_EQ(modes().at(5)["live_pairs"], 105);
  action::frame_shown(viewer, frame_of(2, false));
  EXPECT_EQ(modes().at(5)["live_frames_ago"], 1);
}

}  // namespace
}  // namespace qs
