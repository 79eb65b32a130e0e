// SPDX-License-Identifier: MIT
//
// Frames of the window that count the pairs of all modes.
#include <gtest/gtest.h>

#include "app/support/rendering_viewer.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/state/samples.h"
#include "support/mode_pairs.h"
#include "support/pool.h"

namespace qs {
namespace {

TEST(CountingPace, spends_at_most_a_tenth_of_the_time_of_drawing_on_counting) {
  const auto frames_between = [](float frame_ms, float count_ms) {
    CountingPace pace;
    EXPECT_TRUE(pace.counts_next()) << "the first frame counts";
    RenderStats stats;
    stats.frame_ms = frame_ms;
    stats.count_ms = count_ms;
    pace.learn(stats, true);
    int frames = 1;
    for (; !pace.counts_next() && frames < 100; ++frames) pace.learn({}, false);
    return frames;
  };
  EXPECT_EQ(frames_between(10, 0), 2) << "on a GPU, where it is not measured";
  EXPECT_EQ(frames_between(10, 0.9f), 1);
  EXPECT_EQ(frames_between(10, 1.1f), 2);
  EXPECT_EQ(frames_between(10, 4.5f), 5);
  EXPECT_EQ(frames_between(10, 1000), kMostFramesAgo);
  EXPECT_EQ(frames_between(0, 1), 1);
}

TEST(Occlusion, is_of_pictures_beside_which_no_mode_is_measured) {
  Viewer viewer;
  viewer.scene.emplace();
  viewer.panels.hud = false;
  FrameRequest request;
  EXPECT_TRUE(may_occlude(viewer, request));
  EXPECT_FALSE(full_frame(viewer).settings.occlusion) << "films are of all Gaussians";
  viewer.occlusion = false;
  EXPECT_FALSE(may_occlude(viewer, request)) << "the user's choice";
  viewer.occlusion = true;
  viewer.panels.hud = viewer.panels.all = true;
  EXPECT_FALSE(may_occlude(viewer, request)) << "the table is open";
  viewer.panels.all = false;
  viewer.shows_badge = true;
  EXPECT_FALSE(may_occlude(viewer, request)) << "the picture has the mode's numbers on it";
  viewer.shows_badge = false;
  request.heatmap = HeatQuantity::pairs;
  EXPECT_FALSE(may_occlude(viewer, request)) << "the heat map counts all pairs";
  request.heatmap.reset();
  request.grid = true;
  EXPECT_FALSE(may_occlude(viewer, request)) << "the pictures of all modes compare them";
}

class CountingFrames : public test::RenderingViewer {
 protected:
  CountingFrames() {
    change([](Viewer& viewer) { viewer.panels.hud = true; });
  }

  std::vector<ModePairs> expected() const {
    const auto renderer = make_renderer(Backend::cpu, test::pool(1));
    renderer->upload(test::random_cloud(300, 1, 5), {});
    return test::own_statistics(*renderer, viewer().camera, viewer().settings);
  }

  /// Requests what the loop would request, and shows the frame. False if nothing was drawn.
  bool turn() {
    requests_.update(viewer(), thread_, false);
    const std::optional<RenderedFrame> frame = settle();
    if (!frame) return false;
    requests_.learn(*frame);
    apply(call(action::frame_shown, frame->shown));
    return true;
  }

  FrameRequests requests_;
};

TEST_F(CountingFrames, of_every_kind_count_the_full_size) {
  request_.counted = CountedView{request_.camera, request_.settings};
  std::vector<FrameRequest> requests(6, request_);
  requests[1].divisor = 3;
  requests[2].heatmap = HeatQuantity::pairs;
  requests[3].heatmap = HeatQuantity::missed;
  requests[4].quantity = Quantity::depth;
  requests[5].other = Variant{find_culler("dualbox"), request_.settings.pipeline, Backend::cpu};
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto frame = draw(requests[i]);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->shown.mode_pairs, expected()) << i;
    EXPECT_EQ(frame->shown.view_version, request_.view_version);
  }
  request_.counted.reset();
  EXPECT_TRUE(draw(request_)->shown.mode_pairs.empty());
}

TEST_F(CountingFrames, are_requested_once_for_a_view_while_the_table_is_open) {
  ASSERT_TRUE(turn());
  EXPECT_EQ(viewer().counts.modes, expected());
  EXPECT_TRUE(counts_are_current(viewer()));
  apply(call(action::set_mode, find_culler("adr")));
  ASSERT_TRUE(turn());
  EXPECT_TRUE(viewer().shown.mode_pairs.empty()) << "the mode does not change the counts";
  EXPECT_EQ(live_pairs(viewer(), 1)->frames_ago, 0);
  EXPECT_FALSE(turn());
  Camera camera = viewer().camera;
  camera.view_from_world[3].z += 0.5;
  apply(call(action::set_camera, camera));
  ASSERT_TRUE(turn());
  EXPECT_EQ(viewer().counts.modes, expected());
  EXPECT_EQ(live_pairs(viewer(), 3)->tile_pairs, expected()[2].tile_pairs);
}

TEST_F(CountingFrames, begin_when_the_table_is_opened_and_end_when_it_is_closed) {
  change([](Viewer& viewer) {
    viewer.panels.hud = false;
    viewer.last_motion = -1e9;
  });
  ASSERT_TRUE(turn());
  EXPECT_FALSE(live_pairs(viewer(), 1));
  EXPECT_TRUE(is_settled(viewer()));
  EXPECT_FALSE(turn());
  apply(call(action::toggle_panel, &Panels::hud));
  EXPECT_TRUE(counts_are_missing(viewer()));
  EXPECT_FALSE(is_settled(viewer()));
  ASSERT_TRUE(turn());
  EXPECT_EQ(viewer().counts.modes, expected());
  EXPECT_FALSE(counts_are_missing(viewer()));
  EXPECT_FALSE(turn());
}

TEST_F(CountingFrames, of_a_moving_camera_are_reduced_and_exact) {
  for (int i = 0; i < 30; ++i) {  // learns that frames are slow
    RenderedFrame slow;
    slow.shown.stats.frame_ms = 500;
    slow.shown.stats.count_ms = 1;
    slow.shown.stats.stage_ms[static_cast<int>(Stage::blend)] = 450;
    slow.shown.divisor = viewer().shown.divisor;
    slow.shown.mode_pairs.resize(1);
    requests_.learn(slow);
  }
  change([](Viewer& viewer) {
    action::view_changed(viewer);
    viewer.last_motion = viewer.now;
  });
  ASSERT_TRUE(viewer().moving());
  ASSERT_TRUE(turn());
  EXPECT_GT(viewer().shown.divisor, 1);
  EXPECT_EQ(viewer().counts.modes, expected());
  EXPECT_EQ(live_pairs(viewer(), 1)->frames_ago, 0);
}

}  // namespace
}  // namespace qs
