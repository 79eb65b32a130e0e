// SPDX-License-Identifier: MIT
//
// Choosing the first view of a scene from candidates.
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/driven_viewer.h"
#include "app/viewer/render/panel_pictures.h"
#include "app/viewer/state/camera_actions.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

using test::Driven;
using test::some_scene;
using testing::HasSubstr;
using testing::SizeIs;
using namespace action;

ViewedScene scene_with_candidates(int cameras = 0) {
  ViewedScene scene = some_scene(cameras);
  for (const glm::dvec3 eye : {glm::dvec3(0, -1, -4), glm::dvec3(0, -1, 4), glm::dvec3(4, -1, 0)}) {
    Framing framing = scene.framing;
    framing.eye = eye;
    scene.candidates.push_back(framing);
  }
  return scene;
}

// A viewer that offers views, and whose frames are shown.
struct Choosing : Driven {
  explicit Choosing(const ViewedScene& scene = scene_with_candidates()) {
    apply([](Viewer& v) { v.offers_views = true; });
    apply(resize, 640, 480);
    open(scene);
  }
  void open(const ViewedScene& scene) {
    apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
  }
  using Driven::open;
  void show() {
    ShownFrame frame;
    frame.version = viewer.version;
    apply(frame_shown, frame);
    apply(follow_view_choice);
  }
  void draw_pictures() {
    show();
    apply(candidates_drawn, viewer.scene->path, std::make_shared<const Image>(720, 135, 3));
  }
  bool is_open() const { return viewer.view_choice.pictures != nullptr; }
};

TEST(FirstViewChoice, is_offered_once_the_first_picture_of_a_new_scene_is_shown) {
  Choosing driven;
  driven.apply(follow_view_choice);
  EXPECT_THAT(driven.jobs, SizeIs(0)) << "the first picture comes first";
  driven.show();
  EXPECT_THAT(driven.jobs, SizeIs(1));
  driven.show();
  EXPECT_THAT(driven.jobs, SizeIs(1));
  EXPECT_FALSE(driven.is_open());
  driven.draw_pictures();
  EXPECT_TRUE(driven.is_open());
}

TEST(FirstViewChoice, is_the_first_view_from_then_on) {
  Choosing driven;
  driven.draw_pictures();
  driven.apply(choose_first_view, std::size_t{1});
  EXPECT_FALSE(driven.is_open());
  const glm::dvec3 eye = driven.viewer.camera.position();
  EXPECT_LT(glm::distance(eye, glm::dvec3(0, -1, 4)), 1e-9);
  EXPECT_LT(glm::distance(driven.viewer.pivot, driven.viewer.scene->framing.target), 1e-9);
  driven.press("F");
  driven.press("Home");
  EXPECT_EQ(driven.viewer.camera.position(), eye);
  // The scene opens with it later, and offers nothing.
  Choosing later{some_scene(1)};
  later.apply([&](Viewer& viewer) { viewer.first_views = driven.viewer.first_views; });
  ViewedScene other = some_scene(0);
  other.path = "/data/other.ply";
  later.open(other);
  later.apply([](Viewer& viewer) { viewer.last_views.clear(); });
  EXPECT_LT(glm::distance(opening_view(later.viewer, scene_with_candidates()).position(), eye),
            1e-9);
  later.open(scene_with_candidates());
  EXPECT_LT(glm::distance(later.viewer.camera.position(), eye), 1e-9);
  EXPECT_FALSE(later.viewer.view_choice.wanted);
}

TEST(FirstViewChoice, is_not_offered_where_it_would_disturb) {
  const auto offers = [](const ViewedScene& scene, auto change) {
    Driven driven;
    driven.apply([](Viewer& viewer) { viewer.offers_views = true; });
    driven.apply(change);
    driven.apply(resize, 640, 480);
    driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
    return driven.viewer.view_choice.wanted;
  };
  const auto nothing = [](Viewer&) {};
  EXPECT_TRUE(offers(scene_with_candidates(), nothing));
  EXPECT_FALSE(offers(scene_with_candidates(), [](Viewer& v) { v.offers_views = false; }));
  EXPECT_FALSE(offers(scene_with_candidates(2), nothing)) << "it has cameras";
  EXPECT_FALSE(offers(some_scene(0), nothing)) << "nothing to choose from";
  for (auto map : {&Viewer::last_views, &Viewer::first_views}) {
    EXPECT_FALSE(offers(scene_with_candidates(), [map](Viewer& viewer) {
      (viewer.*map)["/data/garden.ply"] = "{}";
    })) << "the scene is known";
  }
}

TEST(FirstViewChoice, closes_by_escape_by_moving_and_with_another_scene) {
  const std::function<void(Choosing&)> ends[] = {
      [](Choosing& d) { d.apply(close_view_choice); },
      [](Choosing& d) { d.apply(orbit, glm::dvec2(5, 0)); },
      [](Choosing& d) { d.press("F"); },
      [](Choosing& d) { d.open(some_scene(2)); },
  };
  for (const auto& end : ends) {
    for (const bool drawn : {true, false}) {
      Choosing driven;
      driven.show();
      if (drawn) driven.draw_pictures();
      end(driven);
      driven.apply(candidates_drawn, std::filesystem::path("/data/garden.ply"),
                   std::make_shared<const Image>(720, 135, 3));
      EXPECT_FALSE(driven.is_open()) << "pictures that come late are ignored";
      EXPECT_FALSE(driven.viewer.view_choice.wanted);
    }
  }
  Choosing resized;
  resized.draw_pictures();
  resized.apply(resize, 800, 600);
  EXPECT_TRUE(resized.is_open());
  resized.apply(candidates_drawn, std::filesystem::path("/data/other.ply"), nullptr);
  EXPECT_TRUE(resized.is_open());
}

TEST(FirstViewChoice, opens_again_by_its_command_which_says_why_there_is_none) {
  Choosing driven;
  driven.apply(orbit, glm::dvec2(5, 0));
  driven.apply(tick, Turn{9}, 0.0);
  driven.press("Shift+Home");
  driven.draw_pictures();
  EXPECT_TRUE(driven.is_open());
  driven.apply(choose_first_view, std::size_t{3});
  EXPECT_TRUE(driven.is_open()) << "there is no fourth view";
  test::DrivenScene with_cameras(2), without(0);
  with_cameras.press("Shift+Home");
  EXPECT_THAT(with_cameras.viewer.toasts.back().text, HasSubstr("first camera"));
  without.press("Shift+Home");
  EXPECT_THAT(without.viewer.toasts.back().text, HasSubstr("no other views"));
}

}  // namespace
}  // namespace qs
