// SPDX-License-Identifier: MIT
//
// The arrow to the subject of a scene that the user has lost.
#include "app/viewer/state/lost.h"

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/driven_viewer.h"
#include "app/viewer/commands/commands.h"
#include "app/viewer/pacing.h"

namespace qs {
namespace {

using test::DrivenScene;
using namespace action;

constexpr int kGaussians = 34'321;

// A view at rest, 640 x 480, from the origin along +z; the subject is at `target`.
struct LostViewer : DrivenScene {
  explicit LostViewer(glm::dvec3 target = {0, 0, -5}) : DrivenScene(0) {
    apply([target](Viewer& v) { v.scene->framing.target = target; });
    apply(move, look_at({0, 0, 0}, {0, 0, 1}, {0, -1, 0}, 1, 640, 480));
    show(0, 0);
    apply(tick, Turn{1}, 0.0);
  }
  void show(std::uint32_t visible, std::uint64_t pairs) {
    ShownFrame frame;
    frame.version = viewer.version;
    frame.camera = viewer.camera;
    frame.stats.gaussians = kGaussians;
    frame.stats.visible = visible;
    frame.stats.tile_pairs = pairs;
    apply(frame_shown, frame);
  }
};

TEST(Lost, is_a_view_at_rest_of_less_than_a_hundredth_of_the_gaussians) {
  LostViewer driven;
  EXPECT_TRUE(is_lost(driven.viewer));
  driven.show(343, 400);
  EXPECT_TRUE(is_lost(driven.viewer));
  driven.show(344, 400);
  EXPECT_FALSE(is_lost(driven.viewer));
  driven.show(300, 100'000);
  EXPECT_FALSE(is_lost(driven.viewer)) << "a close view fills the picture";
  driven.show(0, 0);
  driven.apply(orbit, glm::dvec2(1, 0));
  EXPECT_FALSE(is_lost(driven.viewer)) << "the frame of this view is not drawn yet";
  driven.show(0, 0);
  EXPECT_FALSE(is_lost(driven.viewer)) << "the camera moves";
  driven.apply(tick, Turn{2}, 0.0);
  EXPECT_TRUE(is_lost(driven.viewer));
  driven.apply([](Viewer& viewer) { viewer.shown.stats.is_occluded = true; });
  EXPECT_FALSE(is_lost(driven.viewer)) << "its visible Gaussians were not counted";
  driven.show(0, 0);
  driven.apply([](Viewer& viewer) { viewer.zoom.running = true; });
  EXPECT_FALSE(is_lost(driven.viewer));
  EXPECT_FALSE(is_lost(Viewer()));
}

TEST(Lost, one_gaussian_is_all_or_nothing) {
  LostViewer driven;
  const auto lost = [&](std::uint32_t visible) {
    driven.apply([visible](Viewer& viewer) {
      viewer.shown.stats.gaussians = 1;
      viewer.shown.stats.visible = visible;
    });
    return is_lost(driven.viewer);
  };
  EXPECT_TRUE(lost(0));
  EXPECT_FALSE(lost(1));
}

void expect_way(glm::dvec3 target, glm::dvec2 direction, glm::dvec2 tip) {
  SCOPED_TRACE(testing::Message() << target.x << " " << target.y << " " << target.z);
  const LostViewer driven(target);
  const auto way = way_to_subject(driven.viewer);
  ASSERT_TRUE(way);
  EXPECT_LT(glm::distance(way->direction, direction), 1e-9);
  EXPECT_LT(glm::distance(way->tip, tip), 1e-6);
}

// The tips are 24 pixels inside of 640 x 480.
TEST(Lost, the_arrow_points_to_the_nearer_way_to_turn) {
  expect_way({9, 0, -5}, {1, 0}, {319.5 + 296, 239.5});    // behind to the right
  expect_way({-9, 0, -5}, {-1, 0}, {319.5 - 296, 239.5});  // behind to the left
  expect_way({0, -9, 0}, {0, -1}, {319.5, 239.5 - 216});   // above
  expect_way({0, 0, -5}, {1, 0}, {319.5 + 296, 239.5});    // right behind: either side
  expect_way({0, 0, 0}, {1, 0}, {319.5 + 296, 239.5});     // at the eye
  expect_way({90, 0, 5}, {1, 0}, {319.5 + 296, 239.5});    // in front, outside of the picture
  expect_way({5, 5, 5}, glm::normalize(glm::dvec2(1, 1)), {319.5 + 216, 239.5 + 216});
  expect_way({0, 0, 5}, {1, 0}, {319.5, 239.5});  // in the middle of the picture
}

TEST(Lost, the_arrow_to_a_subject_behind_does_not_point_over_a_pole) {
  // Looking straight away from a subject that is a little lower: a turn down ends at the pole.
  const LostViewer driven({0.1, 0.5, -5});
  const glm::dvec2 direction = way_to_subject(driven.viewer).value().direction;
  EXPECT_GT(direction.x, 0.99);
  EXPECT_GT(direction.y, 0);
}

TEST(Lost, the_arrow_s_words_name_the_keys_of_the_commands) {
  EXPECT_EQ(command_hint("First view"), "First view (Home)");
  EXPECT_EQ(command_hint("Back to the view before"), "Back to the view before (Backspace)");
  EXPECT_THAT(kWayBack, testing::StrEq("Home: first view, Backspace: back"));
}

TEST(Lost, the_window_is_drawn_when_the_arrow_comes) {
  LostViewer driven;
  Pacing pacing;
  const auto wants = [&] { return pacing.wants_to_draw(driven.viewer, {100, -1e9, false, false}); };
  driven.show(5000, 5000);
  pacing.begin_drawing(driven.viewer);
  EXPECT_FALSE(wants());
  driven.show(0, 0);
  EXPECT_TRUE(wants());
  pacing.begin_drawing(driven.viewer);
  EXPECT_FALSE(wants());
}

}  // namespace
}  // namespace qs
