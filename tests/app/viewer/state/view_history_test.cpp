// SPDX-License-Identifier: MIT
//
// The history of views: every completed move is a step back and forward.
#include "app/viewer/state/view_history.h"

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/driven_viewer.h"
#include "app/viewer/state/camera_actions.h"
#include "io/camera/cameras.h"
#include "support/scenes.h"

namespace qs {
namespace {

using test::DrivenScene;
using test::some_scene;
using testing::SizeIs;
using namespace action;

Camera looking_along(double x) { return look_at({x, 0, -4}, {x, 0, 0}, {0, -1, 0}, 1, 640, 480); }

double x_of(const PastView* view) { return view == nullptr ? -1 : view->camera.position().x; }

// The time passes in turns of the loop.
void rest(DrivenScene& driven, double seconds) {
  const double end = driven.viewer.now + seconds;
  while (driven.viewer.now < end) driven.apply(tick, Turn{driven.viewer.now + 0.05}, 0.05);
}

TEST(ViewHistory, steps_back_and_forward_and_forgets_what_a_new_view_replaces) {
  ViewHistory history;
  EXPECT_EQ(history.back(), nullptr);
  EXPECT_EQ(history.forward(), nullptr);
  for (const double x : {1, 2, 3}) history.keep({looking_along(x)});
  EXPECT_EQ(x_of(history.back()), 2);
  EXPECT_EQ(x_of(history.back()), 1);
  EXPECT_EQ(history.back(), nullptr);
  EXPECT_EQ(x_of(history.forward()), 2);
  history.keep({looking_along(4)});
  EXPECT_EQ(history.forward(), nullptr);
  EXPECT_EQ(x_of(history.back()), 2);
  EXPECT_EQ(x_of(history.back()), 1);
}

TEST(ViewHistory, equal_views_are_one_step_at_every_size_of_the_window) {
  ViewHistory history;
  history.keep({looking_along(1)});
  history.keep({looking_along(2), glm::dvec3(0), 3});
  history.back();
  history.keep({looking_along(1).resized(1280, 333).resized(77, 1000), glm::dvec3(5)});
  ASSERT_THAT(history.views, SizeIs(2));
  EXPECT_EQ(history.views[0].pivot, glm::dvec3(5)) << "the newer pivot";
  EXPECT_EQ(x_of(history.forward()), 2) << "later views stay";
  Camera other = looking_along(2);
  other.near_depth = 0.1;
  EXPECT_FALSE(same_view(other, looking_along(2)));
  other = looking_along(2);
  other.focal_px *= 1.001;
  EXPECT_FALSE(same_view(other, looking_along(2)));
}

TEST(ViewHistory, keeps_a_hundred_views) {
  ViewHistory history;
  for (int i = 0; i < 150; ++i) history.keep({looking_along(i)});
  EXPECT_THAT(history.views, SizeIs(kMostViews));
  int steps = 0;
  double x = 149;
  for (const PastView* view = history.back(); view != nullptr; view = history.back()) {
    x = x_of(view);
    ++steps;
  }
  EXPECT_EQ(steps, 99);
  EXPECT_EQ(x, 50);
}

TEST(Back, undoes_every_kind_of_move_and_redoes_it) {
  const std::function<void(DrivenScene&)> moves[] = {
      [](DrivenScene& d) { d.apply(orbit, glm::dvec2(40, 10)); },
      [](DrivenScene& d) { d.apply(pan, glm::dvec2(40, 10)); },
      [](DrivenScene& d) { d.apply(dolly, 2.0); },
      [](DrivenScene& d) { d.apply(change_fov, 1.0); },
      [](DrivenScene& d) { d.apply(roll, 1.0); },
      [](DrivenScene& d) {
        for (int i = 0; i < 5; ++i) {
          d.apply(fly, glm::dvec3(0, 0, 1), 1.0);
          d.apply(tick, Turn{d.viewer.now + 0.05}, 0.05);
        }
      },
      [](DrivenScene& d) { d.press("F"); },
      [](DrivenScene& d) { d.press("]"); },
      [](DrivenScene& d) { d.apply(frame_point, glm::dvec3(0.1, 0.2, 0.3)); },
      [](DrivenScene& d) {
        d.text = format_camera(test::front_camera(64, 48));
        d.press("Ctrl+V");
      },
      [](DrivenScene& d) {
        d.apply(set_keyframes, std::vector<Keyframe>{{0, looking_along(1)}, {1, looking_along(2)}});
        d.apply(seek, 0.5);
      },
  };
  int number = 0;
  for (const auto& move_it : moves) {
    SCOPED_TRACE(number++);
    DrivenScene driven(3);
    rest(driven, 1);
    const Camera before = driven.viewer.camera;
    const glm::dvec3 pivot = driven.viewer.pivot;
    move_it(driven);
    rest(driven, 2);
    const Camera after = driven.viewer.camera;
    const glm::dvec3 later_pivot = driven.viewer.pivot;
    ASSERT_FALSE(same_view(after, before));
    ASSERT_THAT(driven.viewer.history.views, SizeIs(2));
    driven.press("Backspace");
    EXPECT_TRUE(same_view(driven.viewer.camera, before));
    EXPECT_EQ(driven.viewer.pivot, pivot);
    EXPECT_EQ(driven.viewer.dataset_camera, 0);
    rest(driven, 1);
    driven.press("Shift+Backspace");
    EXPECT_TRUE(same_view(driven.viewer.camera, after));
    EXPECT_EQ(driven.viewer.pivot, later_pivot);
    rest(driven, 1);
    EXPECT_THAT(driven.viewer.history.views, SizeIs(2));
  }
}

TEST(Back, takes_moves_within_a_quarter_of_a_second_as_one_step) {
  DrivenScene driven(1);
  rest(driven, 1);
  for (int i = 0; i < 6; ++i) {
    driven.apply(dolly, 1.0);
    rest(driven, 0.15);
  }
  rest(driven, 0.5);
  EXPECT_THAT(driven.viewer.history.views, SizeIs(2));
  driven.apply(dolly, 1.0);
  rest(driven, 0.5);
  EXPECT_THAT(driven.viewer.history.views, SizeIs(3));
}

TEST(Back, returns_to_the_begin_of_a_move_that_has_not_ended) {
  DrivenScene driven(1);
  rest(driven, 1);
  const Camera before = driven.viewer.camera;
  driven.apply(orbit, glm::dvec2(40, 10));
  const Camera moved = driven.viewer.camera;
  driven.press("Backspace");
  EXPECT_TRUE(same_view(driven.viewer.camera, before));
  driven.press("Shift+Backspace");
  EXPECT_TRUE(same_view(driven.viewer.camera, moved));
  // A jump right after a drag is a step of its own.
  driven.apply(orbit, glm::dvec2(-10, 10));
  const Camera dragged = driven.viewer.camera;
  driven.press("F");
  driven.press("Backspace");
  EXPECT_TRUE(same_view(driven.viewer.camera, dragged));
}

TEST(Back, goes_several_steps_while_the_camera_travels) {
  DrivenScene driven(3);
  driven.apply([](Viewer& viewer) { viewer.animates_moves = true; });
  const Camera first = driven.viewer.camera;
  for (const char* key : {"]", "]", "F"}) {
    driven.press(key);
    rest(driven, 1);
  }
  ASSERT_THAT(driven.viewer.history.views, SizeIs(4));
  for (int i = 0; i < 3; ++i) {
    driven.press("Backspace");
    rest(driven, 0.1);
  }
  EXPECT_TRUE(driven.viewer.travel.has_value());
  rest(driven, 1);
  EXPECT_TRUE(same_view(driven.viewer.camera, first));
  EXPECT_EQ(driven.viewer.dataset_camera, 0);
  EXPECT_THAT(driven.viewer.history.views, SizeIs(4));
}

TEST(Back, stops_at_the_first_view_with_one_sentence_and_begins_anew_with_another_scene) {
  DrivenScene driven(2);
  driven.press("Backspace");
  driven.press("Backspace");
  ASSERT_THAT(driven.viewer.toasts, SizeIs(1));
  EXPECT_EQ(driven.viewer.toasts[0].text, "there is no earlier view of this scene");
  driven.press("]");
  EXPECT_THAT(driven.viewer.history.views, SizeIs(2));
  driven.apply(scene_opened, OpenedScene{some_scene(2), RenderSettings(), Backend::cpu});
  EXPECT_THAT(driven.viewer.history.views, SizeIs(2)) << "the same scene";
  ViewedScene other = some_scene(0);
  other.path = "/data/other.ply";
  driven.apply([](Viewer& viewer) {
    viewer.last_views["/data/other.ply"] = format_camera(looking_along(3));
  });
  driven.apply(scene_opened, OpenedScene{other, RenderSettings(), Backend::cpu});
  ASSERT_THAT(driven.viewer.history.views, SizeIs(1));
  EXPECT_EQ(driven.viewer.history.views[0].camera.position().x, 3);
  test::Driven empty;
  empty.press("Backspace");
  EXPECT_THAT(empty.viewer.toasts, SizeIs(0));
}

}  // namespace
}  // namespace qs
