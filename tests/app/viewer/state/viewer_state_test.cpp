// SPDX-License-Identifier: MIT
//
// The exact effect of every action and key: steps, directions, wrap-around, both ends of every
// range.
#include <cmath>
#include <fstream>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/camera_control.h"
#include "app/framing/first_view.h"
#include "app/support/driven_viewer.h"
#include "app/viewer/commands/input.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/pacing.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/panel_text.h"
#include "app/viewer/state/zoom_actions.h"
#include "base/error.h"
#include "io/camera/cameras.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::Driven;
using test::DrivenScene;
using test::some_scene;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using namespace action;

const glm::dvec3 kUp(0, -1, 0);

std::string text_of(const Camera& camera) { return format_camera(camera); }

// ---- motion -------------------------------------------------------------------------------------
// Each motion leaves the camera of the data set and marks the time.
template <class Change>
Camera moved(const Change& change) {
  DrivenScene driven(2);
  driven.apply(tick, Turn{7}, 0.0);
  const int version = driven.viewer.version, view_version = driven.viewer.view_version;
  change(driven);
  EXPECT_EQ(driven.viewer.dataset_camera, -1);
  EXPECT_EQ(driven.viewer.last_motion, 7);
  EXPECT_EQ(driven.viewer.version, version + 1);
  EXPECT_EQ(driven.viewer.view_version, view_version + 1);
  return driven.viewer.camera;
}

TEST(Motion, has_the_documented_steps) {
  const DrivenScene start(2);
  const Camera camera = start.viewer.camera;
  const glm::dvec3 pivot = start.viewer.pivot;
  const double depth = depth_of(camera, pivot);
  ASSERT_NEAR(depth, std::sqrt(10.0), 0.01);
  EXPECT_EQ(text_of(moved([](Driven& d) { d.apply(orbit, glm::dvec2(10, -4)); })),
            text_of(orbited(camera, pivot, kUp, 0.05, -0.02)));
  EXPECT_EQ(text_of(moved([](Driven& d) { d.apply(dolly, 2.0); })),
            text_of(stepped(camera, {0, 0, depth - depth * 0.81})));
  EXPECT_EQ(text_of(moved([](Driven& d) { d.apply(change_fov, 2.0); })),
            text_of(with_vertical_fov(camera, vertical_fov(camera) * 0.94 * 0.94)));
  EXPECT_EQ(text_of(moved([](Driven& d) { d.apply(roll, 3.0); })),
            text_of(rolled(camera, glm::radians(6.0))));
  EXPECT_EQ(text_of(moved([](Driven& d) { d.apply(pan, glm::dvec2(30, -20)); })),
            text_of(stepped(camera, pan_step(camera, depth, {30, -20}))));
  const glm::dvec2 angles = glm::dvec2(30, -20) / camera.focal_px;
  EXPECT_EQ(text_of(moved([](Driven& d) { d.apply(look, glm::dvec2(30, -20)); })),
            text_of(turned(camera, kUp, -angles.x, angles.y)));
}

TEST(Motion, takes_the_pivot_along_when_it_shifts_the_camera) {
  DrivenScene driven(1);
  const glm::dvec3 pivot = driven.viewer.pivot, position = driven.viewer.camera.position();
  driven.apply(pan, glm::dvec2(30, -20));
  EXPECT_LT(glm::distance(driven.viewer.pivot - pivot, driven.viewer.camera.position() - position),
            1e-12);
  driven.apply(shift, glm::dvec3(1, -1, 1));
  EXPECT_LT(glm::distance(driven.viewer.pivot - pivot, driven.viewer.camera.position() - position),
            1e-12);
  EXPECT_GT(glm::distance(driven.viewer.pivot, pivot), 0.1);
}

TEST(Motion, a_pivot_behind_the_camera_counts_as_a_thousandth_of_the_extent) {
  DrivenScene driven(1);
  driven.apply([](Viewer& viewer) { viewer.pivot = {0, -1, -100}; });
  const Camera camera = driven.viewer.camera;
  driven.apply(dolly, 1.0);
  EXPECT_NEAR(glm::distance(driven.viewer.camera.position(), camera.position()), 0.1 * 2e-3, 1e-12);
  Driven empty;
  empty.apply(resize, 100, 50);
  const glm::dvec3 before = empty.viewer.camera.position();
  empty.apply(action::fly, glm::dvec3(1, 0, 0), 1.0);
  empty.apply(tick, Turn{1}, 0.1);
  EXPECT_EQ(empty.viewer.camera.position(), before);
  empty.apply(orbit, glm::dvec2(0, 3));  // around the usual up, -y
  EXPECT_LT(empty.viewer.version, 4);
}

TEST(Motion, the_first_pivot_is_beside_the_core_and_in_front_of_the_camera) {
  DrivenScene driven(0);
  Camera away = look_at({0, 0, 5}, {0, 0, 9}, kUp, 1, 640, 480);
  driven.apply(set_camera, away);
  EXPECT_LT(glm::distance(driven.viewer.pivot, glm::dvec3(0, 0, 5.1)),
            1e-9);  // 0.05 of the extent, 2
  away = look_at({1, 0, -5}, {1, 0, 0}, kUp, 1, 640, 480);
  driven.apply(set_camera, away);
  EXPECT_LT(glm::distance(driven.viewer.pivot, glm::dvec3(1, 0, 0)), 1e-9);
}

TEST(Motion, sizes_below_one_and_the_same_size_change_nothing) {
  Driven driven;
  driven.apply(resize, 0, 5);
  driven.apply(resize, 5, 0);
  EXPECT_EQ(driven.viewer.version, 0);
  driven.apply(resize, 1, 1);
  EXPECT_EQ(driven.viewer.version, 1);
  EXPECT_EQ(driven.viewer.camera.width, 1);
  EXPECT_EQ(driven.viewer.camera.height, 1);
  driven.apply(resize, 1, 1);
  EXPECT_EQ(driven.viewer.version, 1);
  driven.apply(resize, 1, 2);
  driven.apply(resize, 2, 2);
  EXPECT_EQ(driven.viewer.version, 3);
  EXPECT_EQ(driven.viewer.view_version, 3);
}

TEST(Motion, framing_uses_the_window_s_size_and_up) {
  Driven driven;
  driven.apply(resize, 300, 500);
  ViewedScene scene = some_scene(0);
  scene.up = {0, 0, 1};
  scene.framing.eye = {1.5, -6, 4};
  scene.framing.target = {1.5, 3.5, 3.5};
  scene.framing.up = scene.up;
  driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
  const Camera framed = framed_camera(scene.framing, 300, 500);
  EXPECT_EQ(text_of(driven.viewer.camera), text_of(framed));
  EXPECT_EQ(text_of(driven.viewer.home), text_of(framed));
  EXPECT_EQ(driven.viewer.pivot, glm::dvec3(1.5, 3.5, 3.5));
  driven.apply(roll, 4.0);
  driven.apply([](Viewer& viewer) { viewer.pivot = glm::dvec3(9); });
  driven.press("Home");
  EXPECT_EQ(text_of(driven.viewer.camera), text_of(framed));
  EXPECT_EQ(driven.viewer.pivot, glm::dvec3(1.5, 3.5, 3.5));
  driven.apply(roll, 4.0);
  driven.apply([](Viewer& viewer) { viewer.pivot = glm::dvec3(9); });
  driven.press("F");
  EXPECT_EQ(text_of(driven.viewer.camera), text_of(framed));
  EXPECT_EQ(driven.viewer.pivot, glm::dvec3(1.5, 3.5, 3.5));
}

TEST(Motion, framing_shows_what_the_cameras_look_at_from_one_of_them) {
  Driven driven;
  driven.apply(resize, 300, 200);
  driven.apply(scene_opened, OpenedScene{some_scene(0), RenderSettings(), Backend::cpu});
  const ViewedScene other = some_scene(4);
  driven.apply(cameras_opened, OpenedCameras{other.cameras, "cameras.json", {}});
  driven.press("F");
  EXPECT_LT(glm::length(driven.viewer.pivot), 1e-9);  // they look at the origin
  EXPECT_NEAR(glm::length(driven.viewer.camera.position()), std::sqrt(10.0), 1e-9);
  EXPECT_EQ(driven.viewer.dataset_camera, -1);
  EXPECT_LT(glm::distance(driven.viewer.scene->up, glm::dvec3(0, -1, 0)), 1e-9);
}

TEST(Motion, a_view_that_is_declared_upright_is_remembered) {
  Driven driven;
  driven.apply(resize, 300, 200);
  driven.press("U");  // no scene, no effect
  driven.apply(scene_opened, OpenedScene{some_scene(0), RenderSettings(), Backend::cpu});
  const std::filesystem::path scene = driven.viewer.scene->path;
  EXPECT_FALSE(remembered_up(driven.viewer, scene));
  driven.apply(roll, 10.0);
  const glm::dvec3 up = -view_axes(driven.viewer.camera).down;
  const std::string view = text_of(driven.viewer.camera);
  driven.press("U");
  EXPECT_EQ(text_of(driven.viewer.camera), view);
  EXPECT_LT(glm::distance(driven.viewer.scene->up, up), 1e-12);
  ASSERT_TRUE(remembered_up(driven.viewer, scene));
  EXPECT_LT(glm::distance(*remembered_up(driven.viewer, scene), up), 1e-12);
  EXPECT_FALSE(remembered_up(driven.viewer, "/other.ply"));
  driven.press("F");
  EXPECT_NEAR(glm::dot(view_axes(driven.viewer.camera).right, up), 0, 1e-9);
  // The cameras' own up does not replace it.
  driven.apply(cameras_opened, OpenedCameras{some_scene(4).cameras, "cameras.json", {}});
  EXPECT_LT(glm::distance(driven.viewer.scene->up, up), 1e-12);
  // A view from above does not leave F without a horizon.
  const Framing framing = driven.viewer.scene->framing;
  Camera above = driven.viewer.camera;
  above = look_at(framing.target, framing.target + glm::dvec3(0, 1e-3, 1),
                  framing.eye - framing.target, 1, 300, 200);
  driven.apply(set_camera, above);
  driven.press("U");
  driven.press("F");
  EXPECT_TRUE(std::isfinite(driven.viewer.camera.view_from_world[0][0]));
  driven.apply([](Viewer& viewer) { viewer.ups["/bad.ply"] = "upward"; });
  EXPECT_FALSE(remembered_up(driven.viewer, "/bad.ply"));
}

TEST(Motion, every_step_through_the_cameras_wraps_around) {
  DrivenScene driven(5);
  const auto after = [&](int at, const char* key) {
    driven.apply(go_to_camera, at);
    driven.press(key);
    return driven.viewer.dataset_camera;
  };
  for (int at = 0; at < 5; ++at) {
    EXPECT_EQ(after(at, "["), (at + 4) % 5);
    EXPECT_EQ(after(at, "]"), (at + 1) % 5);
    EXPECT_EQ(after(at, "Shift+["), 0);
    EXPECT_EQ(after(at, "Shift+]"), 4);
    EXPECT_EQ(after(at, "N"), at);
    EXPECT_EQ(after(at, "Home"), 0);
  }
  for (const int wrong : {-1, 5}) {
    driven.apply(go_to_camera, 2);
    driven.apply(go_to_camera, wrong);
    EXPECT_EQ(driven.viewer.dataset_camera, 2);
  }
  driven.apply(orbit, glm::dvec2(2, 0));
  driven.press("]");  // from the nearest one
  EXPECT_EQ(driven.viewer.dataset_camera, 3);
}

TEST(Motion, turning_away_counts_as_a_distance_of_one_extent) {
  DrivenScene driven(0);
  const auto nearest = [&](double apart) {
    // Camera 0 is at the viewer's position and looks back; camera 1 is `apart` away and looks in
    // the viewer's direction.
    ViewedScene scene = some_scene(0);
    scene.path = "/data/" + std::to_string(apart);
    scene.cameras = {look_at({0, 0, 0}, {0, 0, -1}, kUp, 1, 640, 480),
                     look_at({apart, 0, 0}, {apart, 0, 1}, kUp, 1, 640, 480)};
    driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
    driven.apply(set_camera, look_at({0, 0, 0}, {0, 0, 1}, kUp, 1, 640, 480));
    driven.press("N");
    return driven.viewer.dataset_camera;
  };
  EXPECT_EQ(nearest(1.99), 1);
  EXPECT_EQ(nearest(2.01), 0);
}

// ---- state --------------------------------------------------------------------------------------
TEST(State, messages_stay_for_5_seconds_and_errors_for_12) {
  Driven driven;
  driven.apply(tick, Turn{1}, 0.0);
  driven.apply(notify, "a");
  driven.apply(notify_error, "b");
  EXPECT_FALSE(driven.viewer.toasts[0].error);
  EXPECT_TRUE(driven.viewer.toasts[1].error);
  const auto left_at = [&](double now) {
    driven.apply(tick, Turn{now}, 0.0);
    return driven.viewer.toasts.size();
  };
  EXPECT_EQ(left_at(6), 2u);
  EXPECT_EQ(left_at(6.001), 1u);
  EXPECT_EQ(left_at(13), 1u);
  EXPECT_EQ(left_at(13.001), 0u);
}

TEST(State, modes_outside_of_the_table_and_the_same_mode_change_nothing) {
  DrivenScene driven(1);
  driven.apply(set_mode, 2);
  const int version = driven.viewer.version;
  for (const CullMode mode : {0, -1, mode_count() + 1, 2}) driven.apply(set_mode, mode);
  EXPECT_EQ(driven.viewer.version, version);
  EXPECT_EQ(driven.viewer.previous_mode, default_mode());
  for (const CullMode mode : {1, mode_count()}) {
    driven.apply(set_mode, mode);
    EXPECT_EQ(driven.viewer.settings.mode, mode);
  }
  EXPECT_EQ(driven.viewer.previous_mode, 1);
  EXPECT_EQ(driven.viewer.version, version + 2);
  driven.apply(peek_previous_mode, false);
  EXPECT_EQ(driven.viewer.version, version + 2);
  driven.apply(peek_previous_mode, true);
  EXPECT_EQ(driven.viewer.version, version + 3);
  EXPECT_EQ(driven.viewer.mode(), 1);
}

TEST(State, ten_recent_scenes_and_120_times_are_kept) {
  Driven driven;
  driven.apply(resize, 64, 48);
  for (int i = 0; i < 12; ++i) {
    ViewedScene scene = some_scene(0);
    scene.path = "/" + std::to_string(i);
    driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
  }
  ASSERT_THAT(driven.viewer.recent, SizeIs(10));
  EXPECT_EQ(driven.viewer.recent.front(), "/11");
  EXPECT_EQ(driven.viewer.recent.back(), "/2");
  ShownFrame frame;
  for (int i = 0; i < 125; ++i) {
    frame.stats.frame_ms = static_cast<float>(i);
    driven.apply(frame_shown, frame);
  }
  ASSERT_THAT(driven.viewer.frame_ms, SizeIs(120));
  EXPECT_EQ(driven.viewer.frame_ms.front(), 5);
  EXPECT_EQ(driven.viewer.frame_ms.back(), 124);
  frame.divisor = 2;
  driven.apply(frame_shown, frame);
  EXPECT_THAT(driven.viewer.frame_ms, SizeIs(120));
  EXPECT_EQ(driven.viewer.shown.divisor, 2);
}

TEST(State, only_frames_of_colours_alone_give_the_time_of_their_mode) {
  DrivenScene driven(0);
  ShownFrame frame;
  frame.mode = find_culler("exact");
  frame.view_version = driven.viewer.view_version;
  frame.stats.frame_ms = 7;
  driven.apply(frame_shown, frame);
  frame.stats.frame_ms = 100;
  const auto shown_with = [&](const std::function<void(ShownFrame&)>& edit) {
    ShownFrame edited = frame;
    edit(edited);
    driven.apply(frame_shown, edited);
    ASSERT_THAT(driven.viewer.live.shown, SizeIs(1));
    EXPECT_EQ(driven.viewer.live.shown.front().ms, 7);
  };
  shown_with([](ShownFrame& edited) { edited.heatmap.emplace(); });
  shown_with([](ShownFrame& edited) { edited.values.emplace(); });
  shown_with([](ShownFrame& edited) { edited.other.emplace(); });
  shown_with([](ShownFrame& edited) { edited.grid.emplace(); });
}

TEST(State, turned_scenes_are_remembered_and_start_at_their_first_view) {
  DrivenScene driven(0);
  const std::string path = driven.viewer.scene->path.string();
  const Camera home = driven.viewer.camera;
  driven.apply(set_camera, test::front_camera(64, 48));
  driven.apply([&](Viewer& viewer) { viewer.ups[path] = "0,0,1"; });
  driven.press("Y");
  EXPECT_EQ(remembered_axes(driven.viewer, path), "RFU");
  EXPECT_TRUE(driven.viewer.ups.empty());
  ViewedScene scene = some_scene(0);
  scene.axes = "RFU";
  driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
  EXPECT_EQ(format_camera(driven.viewer.camera), format_camera(home)) << "not the view before";
  // Files with y up are turned about the x axis first.
  driven.apply([](Viewer& viewer) {
    viewer.scene->axes = "";
    viewer.scene->declared_axes = "RUB";
  });
  driven.press("Y");
  EXPECT_EQ(driven.opened.back().axes, "RDF");
  driven.apply([](Viewer& viewer) { viewer.scene->axes = "LUB"; });
  driven.press("Y");
  EXPECT_EQ(remembered_axes(driven.viewer, path), "");
  driven.apply([&](Viewer& viewer) { viewer.axes[path] = "nonsense"; });
  EXPECT_EQ(remembered_axes(driven.viewer, path), "") << "the settings were edited by hand";
}

TEST(State, a_scene_that_seems_upside_down_is_turned_over_first) {
  DrivenScene driven(2);
  ViewedScene scene = some_scene(2);
  scene.path = "/data/hanging.ply";
  scene.framing.upside_down = true;
  driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
  EXPECT_EQ(driven.viewer.toasts.back().text,
            "The scene seems to be upside down: press Y to turn it");
  std::vector<std::string> tried;
  for (int press = 0; press < 11; ++press) {
    driven.press("Y");
    tried.push_back(driven.opened.back().axes);
    driven.apply([&](Viewer& viewer) {
      viewer.scene->axes = tried.back();
      viewer.scene->framing.upside_down = tried.back().empty();
    });
  }
  EXPECT_THAT(
      tried, ElementsAre("RUB", "RFU", "RBD", "LUF", "LDB", "LDF", "RUF", "RDB", "LUB", "", "RUB"));
}

TEST(State, a_scene_without_a_floor_can_be_turned_over_and_back_and_nothing_is_claimed) {
  Driven driven;
  driven.apply(resize, 640, 480);
  ViewedScene scene = some_scene(0);
  scene.framing.up_is_assumed = true;
  const auto open = [&](const char* path) {
    scene.path = path;
    driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
  };
  open("/data/script.ply");
  EXPECT_TRUE(driven.viewer.toasts.empty()) << "scripts are offered nothing";
  driven.apply([](Viewer& viewer) { viewer.offers_views = true; });
  open("/data/bouquet.ply");
  const Toast toast = driven.viewer.toasts.back();
  EXPECT_THAT(toast.text, HasSubstr("Y tries other axes, Shift+Y turns the scene over"));
  EXPECT_THAT(toast.text, HasSubstr("U makes a view upright"));
  EXPECT_THAT(toast.text, testing::Not(HasSubstr("upside down")));
  EXPECT_EQ(toast.offer, ToastOffer::turn_over);
  driven.press("Y");
  EXPECT_EQ(driven.opened.back().axes, "RFU") << "z up: an object of a modeller lies on its side";
  driven.press("Shift+Y");
  EXPECT_EQ(driven.opened.back().axes, "RUB");
  EXPECT_EQ(remembered_axes(driven.viewer, "/data/bouquet.ply"), "RUB");
  driven.apply([](Viewer& viewer) { viewer.scene->axes = "RUB"; });
  driven.press("Shift+Y");
  EXPECT_EQ(driven.opened.back().axes, "") << "as the file declares them";
  EXPECT_EQ(remembered_axes(driven.viewer, "/data/bouquet.ply"), "");
  driven.apply([](Viewer& viewer) { viewer.toasts.clear(); });
  scene.framing.up_is_assumed = false;
  open("/data/table.ply");
  EXPECT_TRUE(driven.viewer.toasts.empty()) << "a floor shows which side is up";
}

TEST(State, what_is_larger_than_the_scene_is_said_and_left_out_on_request) {
  DrivenScene driven(2);
  ViewedScene scene = some_scene(2);
  scene.path = "/data/covered.ply";
  scene.huge = 3;
  driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
  EXPECT_THAT(driven.viewer.toasts.back().text,
              testing::StartsWith("3 Gaussians are larger than the scene and may cover it"));
  driven.apply(skip_huge, true);
  EXPECT_TRUE(driven.viewer.skips_huge);
  EXPECT_EQ(driven.opened.back().path, "/data/covered.ply");
}

TEST(State, a_scene_with_other_axes_is_another_one) {
  DrivenScene driven(2);
  const auto open = [&](const char* path, const char* axes) {
    driven.press("K");
    driven.apply(zoom_began, ZoomRecord());
    driven.apply(start_zoom_here);
    driven.apply([](Viewer& viewer) {
      viewer.comparison.emplace();
      viewer.inspected.emplace();
    });
    ViewedScene scene = some_scene(2);
    scene.path = path;
    scene.axes = axes;
    const int version = driven.viewer.version;
    RenderSettings settings;
    settings.mode = 1;
    settings.sh_degree = 2;
    driven.apply(scene_opened, OpenedScene{scene, settings, Backend::cuda});
    EXPECT_GT(driven.viewer.version, version);
    EXPECT_EQ(driven.viewer.settings.mode, default_mode());  // stays
    EXPECT_EQ(driven.viewer.settings.sh_degree, 2);
    EXPECT_EQ(driven.viewer.backend, Backend::cuda);
    const bool kept = !driven.viewer.keyframes.empty();
    EXPECT_EQ(driven.viewer.comparison.has_value(), kept);
    EXPECT_EQ(driven.viewer.inspected.has_value(), kept);
    EXPECT_EQ(driven.viewer.zoom.shown.has_value(), kept);
    EXPECT_EQ(driven.viewer.zoom.plan.start.has_value(), kept);
    return kept;
  };
  EXPECT_TRUE(open("/data/garden.ply", ""));
  EXPECT_FALSE(open("/data/garden.ply", "RUB"));
  EXPECT_TRUE(open("/data/garden.ply", "RUB"));
  EXPECT_FALSE(open("/data/b.ply", "RUB"));
}

BenchRow frames_of(const char* mode, std::vector<double> round_ms) {
  BenchRow row;
  row.mode = mode;
  row.pipeline = "cpu";
  row.ms_median = round_ms.front();
  row.round_ms = std::move(round_ms);
  row.pairs = 7;
  return row;
}

TEST(State, more_frames_of_the_same_view_join_its_numbers) {
  Driven driven;
  driven.apply(numbers_measured,
               ModeNumbers{4, {frames_of("3dgs", {5, 1}), frames_of("adr", {2})}});
  driven.apply(numbers_refined, ModeNumbers{4, {frames_of("3dgs", {3, 9, 4})}});
  const std::vector<BenchRow>& rows = driven.viewer.numbers.rows;
  ASSERT_THAT(rows, SizeIs(2));
  EXPECT_THAT(rows[0].round_ms, ElementsAre(5, 1, 3, 9, 4));
  EXPECT_DOUBLE_EQ(rows[0].ms_median, 4);
  EXPECT_DOUBLE_EQ(rows[0].fps_median, 250);
  EXPECT_EQ(rows[0].pairs, 7u);
  EXPECT_THAT(rows[1].round_ms, ElementsAre(2));
  EXPECT_EQ(frames_behind(driven.viewer.numbers), 1u);
  driven.apply(numbers_refined, ModeNumbers{5, {frames_of("3dgs", {8})}});
  EXPECT_THAT(rows[0].round_ms, SizeIs(5)) << "another view";
  driven.apply(numbers_measured, ModeNumbers{4, {frames_of("3dgs", {6})}, true});
  driven.apply(numbers_refined, ModeNumbers{4, {frames_of("3dgs", {8})}});
  EXPECT_THAT(driven.viewer.numbers.rows[0].round_ms, ElementsAre(6)) << "complete";
}

TEST(State, frames_are_wanted_until_every_ratio_is_known_well_or_a_limit_is_reached) {
  Driven driven;
  const auto measured = [&](std::vector<double> base, std::vector<double> other) {
    driven.apply(numbers_measured, ModeNumbers{driven.viewer.view_version,
                                               {frames_of("3dgs", std::move(base)),
                                                frames_of("adr", std::move(other))}});
    return numbers_suffice(driven.viewer);
  };
  EXPECT_FALSE(numbers_suffice(driven.viewer));
  EXPECT_FALSE(measured({2, 2, 2, 2}, {1, 1, 1, 1})) << "four frames";
  EXPECT_TRUE(measured({2, 2, 2, 2, 2}, {1, 1, 1, 1, 1}));
  EXPECT_TRUE(measured({2, 4, 2, 3, 2}, {1, 2, 1, 1.5, 1})) << "slow for both modes alike";
  EXPECT_FALSE(measured({2, 2, 2, 2, 2}, {1, 1.1, 1, 0.9, 1})) << "1.83 to 2.19";
  // Every frame of adr is 30 % slower or faster, but the limits end the measurement.
  std::vector<double> base(99, 2.0), other(99, 1.0);
  for (std::size_t i = 0; i < other.size(); i += 2) other[i] = 1.3;
  EXPECT_FALSE(measured(base, other));
  base.push_back(2);
  other.push_back(1);
  EXPECT_TRUE(measured(base, other)) << "100 frames";
  EXPECT_FALSE(measured({999, 999, 999, 999, 999}, {2000, 3000, 2000, 5000, 3000})) << "19,995 ms";
  EXPECT_TRUE(measured({999, 999, 999, 999, 1004}, {2000, 3000, 2000, 5000, 3000}));
  driven.apply(view_changed);
  EXPECT_FALSE(numbers_suffice(driven.viewer));
  driven.apply(numbers_measured, ModeNumbers{driven.viewer.view_version, {}});
  EXPECT_TRUE(numbers_suffice(driven.viewer)) << "the measurement failed";
}

TEST(State, a_baseline_is_a_mode_of_the_table) {
  Driven driven;
  driven.apply(set_baseline, 2);
  EXPECT_EQ(driven.viewer.baseline, 2);
  for (const CullMode mode : {0, -1, culler_count() + 1}) driven.apply(set_baseline, mode);
  EXPECT_EQ(driven.viewer.baseline, 2);
}

TEST(State, numbers_of_the_other_pipeline_stay_while_the_view_does) {
  Driven driven;
  const auto row = [](const char* mode, const char* pipeline, double ms) {
    BenchRow result;
    result.mode = mode;
    result.pipeline = pipeline;
    result.ms_median = ms;
    return result;
  };
  driven.apply(numbers_measured,
               ModeNumbers{4, {row("a", "x", 1), row("b", "x", 2), row("a", "y", 3)}});
  driven.apply(numbers_measured, ModeNumbers{4, {row("a", "x", 10), row("b", "y", 20)}});
  std::vector<double> times;
  for (const BenchRow& each : driven.viewer.numbers.rows) times.push_back(each.ms_median);
  EXPECT_THAT(times, ElementsAre(10, 20, 2, 3));
  driven.apply(numbers_measured, ModeNumbers{5, {row("a", "x", 7)}});
  EXPECT_THAT(driven.viewer.numbers.rows, SizeIs(1));
  driven.apply(backend_changed, Backend::cuda);
  EXPECT_THAT(driven.viewer.numbers.rows, IsEmpty());
  EXPECT_EQ(driven.viewer.numbers.version, -1);
  EXPECT_EQ(driven.viewer.view_version, 1);
}

TEST(State, keyframes_are_a_second_apart_and_removed_by_their_index) {
  DrivenScene driven(0);
  const auto times = [&] {
    std::vector<double> result;
    for (const Keyframe& each : driven.viewer.keyframes) result.push_back(each.time);
    return result;
  };
  driven.press("Space");
  EXPECT_EQ(driven.viewer.toasts.back().text, "a path needs two keyframes: set them with K");
  for (int i = 0; i < 4; ++i) driven.press("K");
  EXPECT_EQ(driven.viewer.toasts.back().text, "keyframe 4 set");
  EXPECT_THAT(times(), ElementsAre(0, 1, 2, 3));
  driven.press("Space");
  EXPECT_TRUE(driven.viewer.playback.running);
  driven.apply(remove_keyframe, std::size_t{4});
  EXPECT_TRUE(driven.viewer.playback.running);
  driven.apply(remove_keyframe, std::size_t{1});
  EXPECT_FALSE(driven.viewer.playback.running);
  EXPECT_THAT(times(), ElementsAre(0, 2, 3));
  driven.apply(remove_keyframe, std::size_t{2});
  driven.apply(remove_keyframe, std::size_t{0});
  EXPECT_THAT(times(), ElementsAre(2));
  driven.apply(save_keyframes);
  EXPECT_TRUE(driven.written.empty());
  driven.apply(seek, 7.0);
  EXPECT_EQ(driven.viewer.playback.time, 0);
  driven.press("Space");
  EXPECT_FALSE(driven.viewer.playback.running);
  driven.press("K");
  driven.press("Space");
  EXPECT_TRUE(driven.viewer.playback.running);
  driven.apply(save_keyframes);
  const std::filesystem::path path = std::filesystem::current_path() / "garden_path.json";
  EXPECT_EQ(driven.viewer.toasts.back().text, "wrote " + path.string());
  EXPECT_EQ(driven.viewer.toasts.back().path, path);
}

TEST(Keyframes, are_saved_in_place_of_their_own_file_and_never_of_another) {
  const TemporaryFolder folder;
  DrivenScene driven(1);
  driven.apply([&](Viewer& viewer) { viewer.out_dir = folder.path(); });
  driven.press("K");
  driven.press("K");
  const std::filesystem::path path = folder / "garden_path.json";
  driven.apply(save_keyframes);
  EXPECT_EQ(driven.viewer.toasts.back().text, "wrote " + path.string());
  ASSERT_EQ(driven.written.count(path), 1u);
  std::ofstream(path) << driven.written[path];
  driven.apply(save_keyframes);
  EXPECT_EQ(driven.viewer.toasts.back().text,
            "wrote " + path.string() + ", in place of the path that was saved before");
  driven.written.clear();
  std::ofstream(path) << "[{\"time\": 0}, {\"time\": 1}]";
  driven.apply(save_keyframes);
  EXPECT_EQ(driven.written.count(path), 0u) << "it is somebody's";
  EXPECT_EQ(driven.written.count(folder / "garden_path_0001.json"), 1u);
  EXPECT_EQ(driven.viewer.toasts.back().text,
            "wrote " + (folder / "garden_path_0001.json").string() +
                "; garden_path.json is not a path of this program and stays");
}

// Keyframes at 2, 3 and 5 seconds, each of another view.
std::vector<Keyframe> rolling_path(DrivenScene& driven) {
  std::vector<Keyframe> path;
  for (const double time : {2.0, 3.0, 5.0}) {
    path.push_back({time, driven.viewer.camera});
    driven.apply(roll, 1.0);
  }
  return path;
}

TEST(State, a_path_is_played_from_its_start_to_its_end_and_again) {
  DrivenScene driven(0);
  const std::vector<Keyframe> path = rolling_path(driven);
  driven.apply(set_keyframes, path);
  EXPECT_EQ(driven.viewer.toasts.back().text, "opened a path of 3 keyframes: Space plays it");
  driven.apply(seek, 1.0);
  EXPECT_EQ(driven.viewer.playback.time, 2);
  driven.apply(seek, 9.0);
  EXPECT_EQ(driven.viewer.playback.time, 5);
  EXPECT_EQ(driven.viewer.camera.width, 640);
  driven.press("Space");
  EXPECT_EQ(driven.viewer.playback.time, 2);
  driven.apply(tick, Turn{1}, 1.5);
  EXPECT_EQ(driven.viewer.playback.time, 3.5);
  EXPECT_EQ(text_of(driven.viewer.camera), text_of(camera_at(path, 3.5)));
  EXPECT_TRUE(driven.viewer.playback.running);
  driven.press("Space");
  driven.apply(tick, Turn{2}, 0.5);
  EXPECT_EQ(driven.viewer.playback.time, 3.5);
  driven.press("Space");
  driven.apply(tick, Turn{3}, 1.5);
  EXPECT_EQ(driven.viewer.playback.time, 5);
  EXPECT_FALSE(driven.viewer.playback.running);
  driven.apply(set_keyframes, path);
  EXPECT_EQ(driven.viewer.playback.time, 0);
}

TEST(State, a_path_that_loops_returns_to_its_first_keyframe_and_goes_on) {
  DrivenScene driven(0);
  const std::vector<Keyframe> path = rolling_path(driven);
  driven.apply(set_keyframes, path);
  driven.apply(toggle_option, &Viewer::loops_path);
  driven.apply(seek, 99.0);
  EXPECT_EQ(driven.viewer.playback.time, 6.5);  // 3 s, and 1.5 s for the way back
  const auto apart = [](const Camera& a, const Camera& b) {
    double most = 0;
    for (int i = 0; i < 4; ++i)
      most = std::max(most, glm::distance(a.view_from_world[i], b.view_from_world[i]));
    return most;
  };
  EXPECT_LT(apart(driven.viewer.camera, path[0].camera), 1e-12);
  driven.press("Space");
  driven.apply(tick, Turn{1}, 3.5);
  EXPECT_EQ(driven.viewer.playback.time, 5.5);
  EXPECT_EQ(text_of(driven.viewer.camera), text_of(camera_at(closed_path(path), 5.5)));
  driven.apply(tick, Turn{2}, 1.5);
  EXPECT_EQ(driven.viewer.playback.time, 2);
  EXPECT_TRUE(driven.viewer.playback.running);
}

TEST(State, keyframes_ease_and_move_in_time) {
  DrivenScene driven(0);
  for (int i = 0; i < 4; ++i) driven.press("K");
  const auto times = [&] {
    std::vector<double> result;
    for (const Keyframe& each : driven.viewer.keyframes) result.push_back(each.time);
    return result;
  };
  driven.apply(ease_keyframe, std::size_t{2}, true);
  driven.apply(ease_keyframe, std::size_t{9}, true);
  EXPECT_TRUE(driven.viewer.keyframes[2].eases);
  EXPECT_FALSE(driven.viewer.keyframes[1].eases);
  driven.apply(ease_keyframe, std::size_t{2}, false);
  EXPECT_FALSE(driven.viewer.keyframes[2].eases);
  driven.apply(delay_keyframe, std::size_t{2}, 2.5);
  EXPECT_THAT(times(), ElementsAre(0, 1, 3.5, 4.5));
  driven.apply(delay_keyframe, std::size_t{1}, -1.0);
  EXPECT_THAT(times(), ElementsAre(0, DoubleNear(0.05, 1e-12), DoubleNear(2.55, 1e-12),
                                   DoubleNear(3.55, 1e-12)));
  const std::vector<double> before = times();
  driven.apply(delay_keyframe, std::size_t{0}, 2.0);
  driven.apply(delay_keyframe, std::size_t{4}, 2.0);
  EXPECT_EQ(times(), before);
}

TEST(State, a_photograph_is_shown_at_the_nearest_camera) {
  DrivenScene none(2);
  none.press("G");
  EXPECT_FALSE(none.viewer.panels.photograph);
  EXPECT_EQ(none.viewer.toasts.back().text,
            "no photographs were found in a folder 'images' beside the cameras");
  Driven driven;
  driven.apply(resize, 64, 48);
  ViewedScene scene = some_scene(3);
  scene.photographs = {{1, "/1.jpg"}};
  driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
  driven.apply(go_to_camera, 1);
  driven.apply(roll, 0.1);
  driven.press("G");
  EXPECT_TRUE(driven.viewer.panels.photograph);
  EXPECT_EQ(driven.viewer.dataset_camera, 1);
  EXPECT_THAT(driven.photographs, ElementsAre("/1.jpg"));
  driven.press("G");
  EXPECT_FALSE(driven.viewer.panels.photograph);
  driven.apply(set_photograph_opacity, 0.25f);
  EXPECT_EQ(driven.viewer.photograph_opacity, 0.25f);
  driven.apply(set_photograph_wipe, 0.75f);
  EXPECT_EQ(driven.viewer.photograph_wipe, 0.75f);
  driven.apply(set_photograph_wipe, 3.0f);
  EXPECT_EQ(driven.viewer.photograph_wipe, 1);
  driven.apply(cameras_opened, OpenedCameras{scene.cameras, "/x/c.json", {}});
  EXPECT_EQ(driven.viewer.toasts.back().text, "3 cameras from c.json");
  EXPECT_EQ(driven.viewer.scene->cameras_file, "/x/c.json");
  EXPECT_THAT(driven.viewer.scene->photographs, IsEmpty());
  EXPECT_EQ(driven.viewer.dataset_camera, 0);
}

TEST(State, another_scene_opens_in_its_opening_view) {
  for (const int cameras : {0, 2}) {
    for (const bool restores : {false, true}) {
      Driven driven;
      driven.apply(resize, 640, 470);
      driven.apply([&](Viewer& viewer) {
        viewer.restores_views = restores;
        viewer.last_views["/data/garden.ply"] = format_camera(test::front_camera(80, 60));
      });
      const std::string view = text_of(opening_view(driven.viewer, some_scene(cameras)));
      driven.apply(scene_opened, OpenedScene{some_scene(cameras), RenderSettings(), Backend::cpu});
      EXPECT_EQ(view, text_of(driven.viewer.camera)) << cameras << restores;
    }
  }
}

TEST(State, an_opening_ends_with_its_scene_or_a_sentence) {
  DrivenScene driven(1);
  driven.apply(opening_ended, OpeningResult(OpeningFailed{"a.ply: is broken"}));
  EXPECT_EQ(driven.viewer.toasts.back().text, "a.ply: is broken");
  EXPECT_TRUE(driven.viewer.toasts.back().error);
  driven.apply(opening_ended, OpeningResult(OpeningCancelled{"a.ply: cancelled"}));
  EXPECT_EQ(driven.viewer.toasts.back().text, "a.ply: cancelled");
  EXPECT_FALSE(driven.viewer.toasts.back().error);
  const std::size_t messages = driven.viewer.log.size();
  driven.apply(opening_ended, OpeningResult(OpeningCancelled{}));
  EXPECT_EQ(driven.viewer.log.size(), messages);
  EXPECT_EQ(driven.viewer.scene->name, "garden");
  driven.apply(opening_ended, OpeningResult(SceneBeside{"/b.ply", 70}));
  EXPECT_EQ(driven.viewer.beside->gaussians, 70u);
  ViewedScene other = some_scene(0);
  other.name = "other";
  driven.apply(opening_ended, OpeningResult(OpenedScene{other, RenderSettings(), Backend::cpu}));
  EXPECT_EQ(driven.viewer.scene->name, "other");
}

TEST(State, cancelling_stops_reading_and_hides_its_progress) {
  Driven driven;
  driven.apply(show_progress, Loading{"x", "reading", 0.5f});
  driven.apply(cancel_loading);
  EXPECT_EQ(driven.cancelled, 1);
  EXPECT_FALSE(driven.viewer.loading);
  driven.apply(toggle_option, &Viewer::vsync);
  EXPECT_FALSE(driven.viewer.vsync);
  driven.apply(pixel_inspected, InspectedView());
  driven.apply(pixel_inspected, InspectedView());
  EXPECT_EQ(driven.viewer.inspections, 2);
}

// ---- keys ---------------------------------------------------------------------------------------
TEST(Log, keeps_messages_after_they_have_disappeared) {
  Driven driven;
  driven.apply(tick, Turn{187.9}, 0.0);
  driven.apply(notify, std::string("a"));
  driven.apply(notify_error, std::string("b"));
  driven.apply(tick, Turn{1000}, 0.0);
  EXPECT_THAT(driven.viewer.toasts, IsEmpty());
  ASSERT_THAT(driven.viewer.log, SizeIs(2));
  EXPECT_EQ(driven.viewer.log[0].text, "a");
  EXPECT_EQ(log_time(driven.viewer.log[0]), "3:07");
  EXPECT_FALSE(driven.viewer.log[0].error);
  EXPECT_TRUE(driven.viewer.log[1].error);
  for (int i = 0; i < 200; ++i) driven.apply(notify, std::to_string(i));
  ASSERT_THAT(driven.viewer.log, SizeIs(200));
  EXPECT_EQ(driven.viewer.log.front().text, "0");
}

TEST(Keys, open_and_close_their_panels) {
  const std::pair<const char*, bool Panels::*> keys[] = {
      {"Ctrl+O", &Panels::open}, {"F10", &Panels::hud},   {"I", &Panels::info},
      {"B", &Panels::inspector}, {"F1", &Panels::help},   {"Tab", &Panels::all},
      {"L", &Panels::cameras},   {"O", &Panels::frusta},  {"C", &Panels::split},
      {"M", &Panels::messages},  {"Z", &Panels::recorder}};
  for (const auto& [key, panel] : keys) {
    SCOPED_TRACE(key);
    DrivenScene driven(1);
    const bool before = driven.viewer.panels.*panel;
    driven.press(key);
    EXPECT_EQ(driven.viewer.panels.*panel, !before);
    const KeyPress press = parse_key(key);
    EXPECT_EQ(find_key_command(press.key, press.mods)->is_checked(driven.viewer), !before);
    driven.press(key);
    EXPECT_EQ(driven.viewer.panels.*panel, before);
  }
}

TEST(Keys, do_what_their_rows_say) {
  DrivenScene driven(3);
  driven.press("F5");
  EXPECT_EQ(driven.opened.back().path, "/data/garden.ply");
  EXPECT_EQ(driven.opened.back().axes, "");
  driven.press("F11");
  EXPECT_EQ(driven.fullscreens, 1);
  driven.press("Ctrl+Q");
  EXPECT_EQ(driven.quits, 1);
  driven.press("F12");
  EXPECT_THAT(driven.grabs, ElementsAre("./screenshots/garden_window_0001.png"));
  driven.press("V");
  EXPECT_EQ(driven.viewer.navigation, Navigation::fly);
  EXPECT_EQ(driven.viewer.toasts.back().text, "fly: drag looks around, W A S D moves");
  driven.press("V");
  EXPECT_EQ(driven.viewer.navigation, Navigation::orbit);
  EXPECT_EQ(driven.viewer.toasts.back().text, "orbit: drag turns around the pivot");
  driven.press("Ctrl+C");
  EXPECT_EQ(driven.text, text_of(driven.viewer.camera));
  EXPECT_EQ(driven.viewer.toasts.back().text, "camera copied as JSON, ready for --camera-json");
  driven.press("Y");
  EXPECT_EQ(driven.opened.back().axes, "RFU");
  EXPECT_EQ(driven.viewer.toasts.back().text, "read as if its axes were RFU; Y again for others");
  driven.apply([](Viewer& viewer) { viewer.scene->axes = "LUB"; });  // the last axes
  driven.press("Y");
  EXPECT_EQ(driven.opened.back().axes, "");
  EXPECT_EQ(driven.viewer.toasts.back().text, "axes as the file declares them");
}

TEST(Keys, splats_stay_between_a_hundredth_and_ten) {
  DrivenScene driven(1);
  const int version = driven.viewer.view_version;
  driven.press("=");
  EXPECT_EQ(driven.viewer.view_version, version + 1);
  for (int i = 0; i < 40; ++i) driven.press("=");
  EXPECT_EQ(driven.viewer.settings.splat_scale, 10);
  driven.press("-");
  EXPECT_FLOAT_EQ(driven.viewer.settings.splat_scale, 10 / 1.1f);
  for (int i = 0; i < 80; ++i) driven.press("-");
  EXPECT_EQ(driven.viewer.settings.splat_scale, 0.01f);
  const auto pressed = [&](float from) {
    driven.apply([=](Viewer& viewer) { viewer.settings.splat_scale = from; });
    driven.press("=");
    return driven.viewer.settings.splat_scale;
  };
  EXPECT_EQ(pressed(1.0009f / 1.1f), 1);
  EXPECT_EQ(pressed(0.9991f / 1.1f), 1);
  EXPECT_NE(pressed(1.0011f / 1.1f), 1);
}

TEST(Keys, one_of_three_styles_is_drawn_and_ticked) {
  const std::pair<const char*, const char*> rows[] = {
      {"Shift+1", "Draw splats"}, {"Shift+2", "Draw points"}, {"Shift+3", "Draw ellipsoids"}};
  DrivenScene driven(1);
  const auto ticked = [&] {
    std::vector<std::string> helps;
    for (const KeyCommand& row : key_commands())
      if (row.help.starts_with("Draw ") && row.is_checked(driven.viewer)) helps.push_back(row.help);
    return helps;
  };
  EXPECT_EQ(ticked(), std::vector<std::string>{"Draw splats"});
  for (const int style : {1, 2, 0}) {
    const int version = driven.viewer.view_version;
    driven.press(rows[style].first);
    EXPECT_EQ(driven.viewer.settings.style, static_cast<DrawStyle>(style));
    EXPECT_EQ(driven.viewer.view_version, version + 1);
    EXPECT_EQ(ticked(), std::vector<std::string>{rows[style].second});
  }
}

TEST(Keys, heat_maps_follow_in_the_order_of_their_table) {
  DrivenScene driven(1);
  const int version = driven.viewer.version;
  driven.press("Shift+H");  // the last map, without a step
  EXPECT_EQ(driven.viewer.heatmap, HeatQuantity::pairs);
  for (std::size_t i = 1; i <= kHeatQuantities; ++i) {
    driven.press("Shift+H");
    EXPECT_EQ(driven.viewer.heatmap, static_cast<HeatQuantity>(i % kHeatQuantities));
    EXPECT_EQ(driven.viewer.last_heatmap, static_cast<HeatQuantity>(i % kHeatQuantities));
  }
  EXPECT_EQ(driven.viewer.version, version + 1 + static_cast<int>(kHeatQuantities));
  driven.press("H");
  EXPECT_FALSE(driven.viewer.heatmap);
  EXPECT_EQ(driven.viewer.version, version + 2 + static_cast<int>(kHeatQuantities));
}

TEST(Keys, split_views_follow_in_the_order_of_their_table) {
  DrivenScene driven(1);
  for (int i = 1; i <= 4; ++i) {
    driven.press("Shift+C");
    EXPECT_EQ(driven.viewer.split.view, static_cast<SplitView>(i % 4));
  }
  // Another variant needs a frame only while it is shown.
  Split split = driven.viewer.split;
  const int version = driven.viewer.version;
  split.other.mode = 2;
  driven.apply(change_split, split);
  EXPECT_EQ(driven.viewer.version, version);
  driven.press("C");
  EXPECT_EQ(driven.viewer.version, version + 1);
  driven.apply(change_split, split);
  EXPECT_EQ(driven.viewer.version, version + 1);
  split.other.mode = 3;
  driven.apply(change_split, split);
  EXPECT_EQ(driven.viewer.version, version + 2);
}

TEST(Keys, names_are_those_of_the_keyboard) {
  EXPECT_EQ(key_name(GLFW_KEY_F1), "F1");
  EXPECT_EQ(key_name(GLFW_KEY_F25), "F25");
  EXPECT_EQ(key_name(GLFW_KEY_A, GLFW_MOD_CONTROL | GLFW_MOD_ALT | GLFW_MOD_SHIFT),
            "Ctrl+Alt+Shift+A");
  EXPECT_EQ(key_name(GLFW_KEY_ENTER), "Enter");
  const KeyPress press = parse_key("Ctrl+Shift+F12");
  EXPECT_EQ(press.key, GLFW_KEY_F12);
  EXPECT_EQ(press.mods, GLFW_MOD_CONTROL | GLFW_MOD_SHIFT);
  EXPECT_EQ(parse_key("Space").key, GLFW_KEY_SPACE);
  EXPECT_THROW(parse_key("Nokey"), Error);
  EXPECT_EQ(find_key_command(GLFW_KEY_KP_9 + 1, 0), nullptr);
  const std::pair<int, glm::dvec3> directions[] = {
      {GLFW_KEY_W, {0, 0, 1}}, {GLFW_KEY_S, {0, 0, -1}}, {GLFW_KEY_A, {-1, 0, 0}},
      {GLFW_KEY_D, {1, 0, 0}}, {GLFW_KEY_Q, {0, 1, 0}},  {GLFW_KEY_E, {0, -1, 0}}};
  ASSERT_EQ(fly_keys().size(), std::size(directions));
  for (std::size_t i = 0; i < fly_keys().size(); ++i) {
    EXPECT_EQ(fly_keys()[i].key, directions[i].first);
    EXPECT_EQ(fly_keys()[i].direction, directions[i].second);
  }
}

TEST(Keys, files_get_the_first_free_number) {
  const TemporaryFolder folder;
  EXPECT_EQ(free_name(folder.path(), "a", ".png"), folder / "a_0001.png");
  for (const char* name : {"a_0001.png", "a_0002.png", "a_0004.png"})
    std::ofstream(folder / name) << 1;
  EXPECT_EQ(free_name(folder.path(), "a", ".png"), folder / "a_0003.png");
  Viewer viewer;
  EXPECT_EQ(camera_name(viewer), "view");
  viewer.dataset_camera = 0;
  EXPECT_EQ(camera_name(viewer), "camera0");
}

// ---- mouse and held keys ------------------------------------------------------------------------
// Jobs that two clicks start, `seconds` and `pixels` apart: 1 if they pick the pivot.
std::size_t picks(double seconds, double pixels) {
  DrivenScene driven(1);
  Input input;
  Actions actions;
  const auto click = [&](double now) {
    input.button(GLFW_MOUSE_BUTTON_LEFT, true, false, now, actions);
    input.button(GLFW_MOUSE_BUTTON_LEFT, false, false, now, actions);
  };
  input.cursor({100, 100}, Navigation::orbit, actions);
  click(0);
  input.cursor({100 + pixels, 100}, Navigation::orbit, actions);
  click(seconds);
  driven.apply_all(actions);
  return driven.jobs.size();
}

TEST(Mouse, two_clicks_are_one_gesture_within_a_third_of_a_second_and_six_pixels) {
  EXPECT_EQ(picks(0.34, 5.9), 1u);
  EXPECT_EQ(picks(0.35, 0), 0u);
  EXPECT_EQ(picks(0.34, 6), 0u);
}

TEST(Mouse, a_click_inspects_unless_it_moved_three_pixels) {
  const auto inspects = [](double pixels, int button) {
    DrivenScene driven(1);
    driven.press("B");
    Input input;
    Actions actions;
    input.cursor({100, 100}, Navigation::orbit, actions);
    input.button(button, true, false, 1, actions);
    EXPECT_TRUE(input.busy());
    input.button(button == 0 ? 1 : 0, false, false, 1, actions);  // another button's release
    EXPECT_TRUE(input.busy());
    input.cursor({100, 100 + pixels}, Navigation::fly, actions);
    actions.clear();
    input.button(button, false, false, 1, actions);
    EXPECT_FALSE(input.busy());
    driven.apply_all(actions);
    return driven.jobs.size();
  };
  EXPECT_EQ(inspects(2.9, GLFW_MOUSE_BUTTON_LEFT), 1u);
  EXPECT_EQ(inspects(3, GLFW_MOUSE_BUTTON_LEFT), 0u);
  EXPECT_EQ(inspects(0, GLFW_MOUSE_BUTTON_RIGHT), 0u);
}

TEST(Mouse, only_the_picture_can_be_inspected) {
  DrivenScene driven(1);
  driven.press("B");
  const auto started = [&](double x, double y) {
    driven.jobs.clear();
    driven.apply(action::inspect_pixel, glm::dvec2(x, y));
    return driven.jobs.size();
  };
  for (const glm::dvec2 at : {glm::dvec2(0, 0), {639.5, 0}, {0, 479.5}, {600, 300}})
    EXPECT_EQ(started(at.x, at.y), 1u) << at.x << " " << at.y;
  for (const glm::dvec2 at : {glm::dvec2(-0.1, 5), {5, -0.1}, {640, 5}, {5, 480}})
    EXPECT_EQ(started(at.x, at.y), 0u) << at.x << " " << at.y;
}

TEST(Mouse, held_keys_fly_five_times_faster_or_slower) {
  const auto speed = [](int mods) {
    DrivenScene driven(1);
    Input input;
    Actions actions;
    input.key(GLFW_KEY_S, true, false, mods, false, actions);
    EXPECT_EQ(input.busy(), (mods & GLFW_MOD_CONTROL) == 0);
    input.tick(actions);
    driven.apply_all(actions);
    return glm::length(driven.viewer.flight.wish);
  };
  EXPECT_NEAR(speed(0), 1, 1e-12);
  EXPECT_NEAR(speed(GLFW_MOD_SHIFT), 5, 1e-12);
  EXPECT_NEAR(speed(GLFW_MOD_ALT), 0.2, 1e-12);
  EXPECT_NEAR(speed(GLFW_MOD_SHIFT | GLFW_MOD_ALT), 1, 1e-12);
  EXPECT_NEAR(speed(GLFW_MOD_CONTROL), 0, 1e-12);
  EXPECT_NEAR(speed(GLFW_MOD_CAPS_LOCK), 1, 1e-12);
  Input input;
  Actions actions;
  input.wheel(0, 0, false, actions);
  input.key(GLFW_KEY_W, true, false, 0, false, actions);
  input.key(GLFW_KEY_S, true, false, 0, false, actions);
  input.tick(actions);
  EXPECT_THAT(actions, IsEmpty());
}

// ---- pacing and requests ------------------------------------------------------------------------
TEST(Pacing, its_times_end_where_they_say) {
  Viewer viewer;
  viewer.now = 10;
  Pacing pacing;
  pacing.begin_drawing(viewer);
  EXPECT_EQ(pacing.end_drawing(viewer, 0), 0);
  Surroundings around{0.35, 0, false, false};
  EXPECT_FALSE(pacing.wants_to_draw(viewer, around));
  around.now = 0.3499;
  EXPECT_TRUE(pacing.wants_to_draw(viewer, around));
  around = {5.25, -1e9, false, false};
  pacing.note_change(viewer, 4.9);
  pacing.begin_drawing(viewer);
  around.now = 4.9 + 0.35;
  EXPECT_FALSE(pacing.wants_to_draw(viewer, around));
  around.now -= 0.0001;
  EXPECT_TRUE(pacing.wants_to_draw(viewer, around));
  viewer.on_demand = false;
  Surroundings busy{0.03, -1e9, true, false};
  EXPECT_FALSE(pacing.frame_comes_first(viewer, busy));
  busy.now = 0.0299;
  EXPECT_TRUE(pacing.frame_comes_first(viewer, busy));
  EXPECT_EQ(pacing.end_drawing(viewer, 0.25), 0);
  ++viewer.frames;
  EXPECT_EQ(pacing.end_drawing(viewer, 0.25), 0);
  ++viewer.frames;
  EXPECT_NEAR(pacing.end_drawing(viewer, 0.45), 5, 1e-9);
}

TEST(Pacing, the_view_is_still_or_moving_or_neither) {
  Viewer viewer;
  viewer.last_motion = 0;
  const auto states = [&](double now) {
    viewer.now = now;
    return std::pair(viewer.moving(), viewer.still());
  };
  EXPECT_EQ(states(0.1999), std::pair(true, false));
  EXPECT_EQ(states(0.2), std::pair(false, false));
  EXPECT_EQ(states(0.25), std::pair(false, false));
  EXPECT_EQ(states(0.2501), std::pair(false, true));
}

TEST(FrameRequests, a_request_has_everything_of_the_view) {
  DrivenScene driven(2);
  driven.apply(orbit, glm::dvec2(3, 4));
  RenderSettings settings;
  settings.sh_degree = 1;
  driven.apply(change_settings, settings);
  driven.apply(picture_changed);
  const FrameRequest request = full_frame(driven.viewer);
  EXPECT_EQ(text_of(request.camera), text_of(driven.viewer.camera));
  EXPECT_EQ(request.version, driven.viewer.version);
  EXPECT_EQ(request.view_version, driven.viewer.view_version);
  EXPECT_NE(request.version, request.view_version);
  EXPECT_EQ(request.settings.sh_degree, 1);
  EXPECT_EQ(request.divisor, 1);
}

}  // namespace
}  // namespace qs
