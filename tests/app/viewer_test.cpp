// SPDX-License-Identifier: MIT
//
// The viewer's state without a window: actions, the table of keys, input, words of the display.
#include <fstream>
#include <set>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/session/camera_control.h"
#include "app/viewer/render/resolution.h"
#include "app/viewer/render/scene_loader.h"
#include "app/viewer/state/bindings.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/preferences.h"
#include "app/viewer/window/input.h"
#include "app/viewer/window/input_script.h"
#include "io/bytes/json_text.h"
#include "io/scene/axes.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"
#include "test_paths.h"

namespace qs {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using namespace action;

ViewedScene some_scene(int cameras) {
  ViewedScene scene;
  scene.path = "/data/garden.ply";
  scene.name = "garden";
  scene.core = {glm::vec3(-1), glm::vec3(1)};
  scene.smallest_radius = 0.01f;
  scene.gaussians = 500;
  scene.sh_degree = 3;
  for (int i = 0; i < cameras; ++i) {
    scene.cameras.push_back(
        look_at({3.0 * std::sin(i), -1, -3.0 * std::cos(i)}, {0, 0, 0}, {0, -1, 0}, 1, 800, 600));
  }
  return scene;
}

Viewer viewer_with(int cameras) {
  Viewer viewer;
  apply(viewer, Resize{640, 480});
  apply(viewer, SceneOpened{some_scene(cameras), {}, Backend::cpu});
  return viewer;
}

template <class T>
const T* first_request(const Viewer& viewer) {
  for (const Request& request : viewer.requests) {
    if (const T* found = std::get_if<T>(&request)) return found;
  }
  return nullptr;
}

// ---- actions -----------------------------------------------------------------------------------
TEST(Viewer, opens_at_the_first_camera_in_the_window_s_size) {
  const Viewer viewer = viewer_with(3);
  EXPECT_EQ(viewer.dataset_camera, 0);
  EXPECT_EQ(viewer.camera.width, 640);
  EXPECT_EQ(viewer.camera.height, 480);
  EXPECT_LT(glm::distance(viewer.camera.position(), viewer.scene->cameras[0].position()), 1e-12);
  EXPECT_LT(glm::length(viewer.pivot), 0.1);  // what the camera looks at
}

TEST(Viewer, frames_a_scene_without_cameras_upright) {
  const Viewer viewer = viewer_with(0);
  EXPECT_EQ(viewer.dataset_camera, -1);
  EXPECT_GT(depth_of(viewer.camera, glm::dvec3(0)), 1);
  EXPECT_GT(view_axes(viewer.camera).down.y, 0.5);
}

TEST(Viewer, switches_modes_and_back) {
  Viewer viewer = viewer_with(1);
  const int version = viewer.version, view_version = viewer.view_version;
  apply(viewer, SetMode{2});
  EXPECT_EQ(viewer.mode(), 2);
  EXPECT_GT(viewer.version, version);
  EXPECT_EQ(viewer.view_version, view_version);  // every mode's numbers stay true
  apply(viewer, PeekPreviousMode{true});
  EXPECT_EQ(viewer.mode(), kDefaultMode);
  apply(viewer, PeekPreviousMode{false});
  EXPECT_EQ(viewer.mode(), 2);
  apply(viewer, SetMode{99});
  EXPECT_EQ(viewer.mode(), 2);
}

TEST(Viewer, heat_maps_toggle_and_take_turns) {
  Viewer viewer = viewer_with(1);
  apply(viewer, ToggleHeatmap{});
  EXPECT_EQ(viewer.heatmap, HeatQuantity::pairs);
  apply(viewer, NextHeatmap{});
  EXPECT_EQ(viewer.heatmap, HeatQuantity::evaluated);
  apply(viewer, ToggleHeatmap{});
  EXPECT_EQ(viewer.heatmap, std::nullopt);
  apply(viewer, ToggleHeatmap{});
  EXPECT_EQ(viewer.heatmap, HeatQuantity::evaluated);
}

TEST(Viewer, splits_the_window_with_a_variant_that_differs) {
  Viewer viewer = viewer_with(0);
  apply(viewer, SetMode{find_culler("adr")});
  viewer.split.other = viewer.variant();
  const int before = viewer.version;
  apply(viewer, TogglePanel{&Panels::split});
  EXPECT_TRUE(viewer.panels.split);
  EXPECT_NE(viewer.split.other, viewer.variant());
  EXPECT_GT(viewer.version, before);
  // Looking at both in another way draws nothing anew, another variant does.
  const int shown = viewer.version;
  apply(viewer, FlipSplit{});
  EXPECT_TRUE(viewer.split.flipped);
  for (int i = 0; i < 4; ++i) apply(viewer, NextSplitView{});
  EXPECT_EQ(viewer.split.view, SplitView::sides);
  EXPECT_EQ(viewer.version, shown);
  Split split = viewer.split;
  split.other.mode = kReferenceMode;
  apply(viewer, ChangeSplit{split});
  EXPECT_GT(viewer.version, shown);
}

TEST(Viewer, goes_through_all_axes_and_back_to_the_file_s) {
  Viewer viewer = viewer_with(0);
  std::set<std::string> seen;
  for (std::size_t i = 0; i <= kAxes.size(); ++i) {
    apply(viewer, NextAxes{});
    const auto* open = std::get_if<request::Open>(&viewer.requests.back());
    ASSERT_NE(open, nullptr);
    seen.insert(open->axes);
    viewer.scene->axes = open->axes;
  }
  EXPECT_EQ(viewer.scene->axes, "");
  EXPECT_EQ(seen.size(), kAxes.size() + 1);
}

TEST(Viewer, steps_through_cameras_and_leaves_them_by_moving) {
  Viewer viewer = viewer_with(4);
  apply(viewer, StepCamera{CameraStep::previous});
  EXPECT_EQ(viewer.dataset_camera, 3);
  apply(viewer, StepCamera{CameraStep::next});
  EXPECT_EQ(viewer.dataset_camera, 0);
  apply(viewer, StepCamera{CameraStep::last});
  EXPECT_EQ(viewer.dataset_camera, 3);
  apply(viewer, Orbit{{3, 2}});
  EXPECT_EQ(viewer.dataset_camera, -1);
  apply(viewer, StepCamera{CameraStep::nearest});
  EXPECT_EQ(viewer.dataset_camera, 3);
  apply(viewer, StepCamera{CameraStep::first});
  EXPECT_EQ(viewer.dataset_camera, 0);
}

TEST(Viewer, says_so_when_there_are_no_cameras) {
  Viewer viewer = viewer_with(0);
  apply(viewer, StepCamera{CameraStep::next});
  ASSERT_THAT(viewer.toasts, SizeIs(1));
  EXPECT_THAT(viewer.toasts[0].text, HasSubstr("cameras.json"));
  apply(viewer, Tick{100, 0.1});
  EXPECT_THAT(viewer.toasts, IsEmpty());
}

TEST(Viewer, speed_follows_the_scene_s_extent) {
  for (const float extent : {0.1f, 1.0f, 1000.0f}) {
    Viewer viewer;
    apply(viewer, Resize{640, 480});
    ViewedScene scene = some_scene(0);
    scene.core = {glm::vec3(-0.5f * extent), glm::vec3(0.5f * extent)};
    apply(viewer, SceneOpened{scene, {}, Backend::cpu});
    const glm::dvec3 before = viewer.camera.position();
    apply(viewer, Fly{{0, 0, 1}, 1.0});
    const double moved = glm::distance(viewer.camera.position(), before);
    EXPECT_NEAR(moved, 0.25 * static_cast<double>(extent), 1e-4 * static_cast<double>(extent));
  }
}

TEST(Viewer, resizing_keeps_the_vertical_field_of_view) {
  Viewer viewer = viewer_with(2);
  const double fov = vertical_fov(viewer.camera);
  apply(viewer, Resize{1920, 1080});
  EXPECT_NEAR(vertical_fov(viewer.camera), fov, 1e-12);
  EXPECT_EQ(viewer.camera.width, 1920);
  EXPECT_EQ(viewer.dataset_camera, 0);
}

TEST(Viewer, a_failed_load_keeps_the_scene_and_shows_the_sentence) {
  Viewer viewer = viewer_with(1);
  apply(viewer, Open{"/data/broken.ply"});
  ASSERT_NE(first_request<request::Open>(viewer), nullptr);
  apply(viewer, SetLoading{Loading{"/data/broken.ply", "reading", 0.5f}});
  apply(viewer, Say{"/data/broken.ply: is not a ply file", true});
  apply(viewer, SetLoading{});
  EXPECT_EQ(viewer.scene->name, "garden");
  EXPECT_FALSE(viewer.loading);
  EXPECT_TRUE(viewer.toasts.back().error);
}

TEST(Viewer, reopening_a_scene_keeps_the_view) {
  Viewer viewer = viewer_with(2);
  apply(viewer, Orbit{{50, 20}});
  const glm::dvec3 position = viewer.camera.position();
  apply(viewer, SceneOpened{some_scene(2), {}, Backend::cpu});
  EXPECT_EQ(viewer.camera.position(), position);
}

TEST(Viewer, recent_files_are_unique_newest_first) {
  Viewer viewer;
  apply(viewer, Resize{640, 480});
  for (const char* path : {"/a.ply", "/b.ply", "/a.ply"}) {
    ViewedScene scene = some_scene(0);
    scene.path = path;
    apply(viewer, SceneOpened{scene, {}, Backend::cpu});
  }
  EXPECT_THAT(viewer.recent, testing::ElementsAre("/a.ply", "/b.ply"));
}

TEST(Viewer, keyframes_play_along_their_path) {
  Viewer viewer = viewer_with(0);
  apply(viewer, TogglePlayback{});
  EXPECT_FALSE(viewer.playback.running);  // nothing to play
  apply(viewer, AddKeyframe{});
  const Camera first = viewer.camera;
  apply(viewer, Orbit{{200, 0}});
  apply(viewer, AddKeyframe{});
  const Camera second = viewer.camera;
  apply(viewer, TogglePlayback{});
  apply(viewer, TogglePlayback{});
  apply(viewer, Seek{0});
  EXPECT_LT(glm::distance(viewer.camera.position(), first.position()), 1e-9);
  apply(viewer, TogglePlayback{});
  for (int i = 0; i < 20; ++i) apply(viewer, Tick{0.1 * i, 0.1});
  EXPECT_FALSE(viewer.playback.running);
  EXPECT_LT(glm::distance(viewer.camera.position(), second.position()), 1e-9);
  apply(viewer, RemoveKeyframe{7});
  EXPECT_THAT(viewer.keyframes, SizeIs(2));
}

TEST(Viewer, numbers_of_a_hindered_frame_are_no_measurement) {
  Viewer viewer = viewer_with(1);
  EXPECT_THAT(hud_caveat(viewer), HasSubstr("on demand"));
  viewer.on_demand = false;
  EXPECT_THAT(hud_caveat(viewer), HasSubstr("waits for the display"));
  viewer.vsync = false;
  EXPECT_EQ(hud_caveat(viewer), "");
  viewer.shown.divisor = 2;
  EXPECT_EQ(hud_caveat(viewer), "drawn at 1/2 size: not a measurement");
}

TEST(Viewer, the_table_shows_the_numbers_of_the_csv) {
  Viewer viewer = viewer_with(1);
  std::vector<BenchRow> rows(2);
  rows[0].mode = "3dgs";
  rows[0].ms_median = 1.9518;
  rows[0].fps_median = 1000 / 1.9518;
  rows[0].pairs = 5227642;
  rows[0].pairs_per_visible = 20.481;
  rows[1].mode = "quadbox";
  rows[1].ms_median = 0.9612;
  rows[1].fps_median = 1000 / 0.9612;
  rows[1].pairs = 1796352;
  apply(viewer, NumbersMeasured{{viewer.view_version, rows}});
  EXPECT_TRUE(numbers_are_current(viewer));
  const std::string csv = format_csv(rows);
  const std::vector<HudRow> table = hud_rows(viewer);
  ASSERT_THAT(table, SizeIs(kCullerCount));
  EXPECT_EQ(table[0].ms, "1.952");
  EXPECT_THAT(csv, HasSubstr("1.9518"));
  EXPECT_EQ(table[0].pairs, "5,227,642");
  EXPECT_EQ(table[0].per_visible, "20.48");
  EXPECT_EQ(table[0].speedup, "1.00x");
  EXPECT_EQ(table[4].speedup, "2.03x");
  EXPECT_EQ(table[4].fps, "1040");
  EXPECT_EQ(table[1].ms, "-");
  apply(viewer, Orbit{{1, 0}});
  EXPECT_FALSE(numbers_are_current(viewer));
}

// ---- keys and mouse ----------------------------------------------------------------------------
TEST(Bindings, no_key_does_two_things) {
  std::set<std::pair<int, int>> keys;
  std::set<std::string> helps;
  for (const Binding& row : bindings()) {
    EXPECT_TRUE(keys.emplace(row.key, row.mods).second) << row.help;
    EXPECT_TRUE(helps.insert(row.help).second) << row.help;
    EXPECT_NE(row.help, "");
  }
  for (const FlyKey& row : fly_keys()) EXPECT_TRUE(keys.emplace(row.key, 0).second) << row.help;
}

TEST(Bindings, names_of_keys_are_read_back) {
  for (const Binding& row : bindings()) {
    const KeyPress press = parse_key(key_name(row.key, row.mods));
    EXPECT_EQ(press.key, row.key) << key_name(row.key, row.mods);
    EXPECT_EQ(press.mods, row.mods);
  }
}

TEST(Bindings, every_mode_has_its_digit_in_both_rows) {
  for (CullMode mode = 1; mode <= kCullerCount; ++mode) {
    for (const int zero : {GLFW_KEY_0, GLFW_KEY_KP_0}) {
      const Binding* row = find_binding(zero + mode, 0);
      ASSERT_NE(row, nullptr);
      EXPECT_EQ(std::get<SetMode>(row->action).mode, mode);
      EXPECT_EQ(row->menu, Menu::mode);
    }
  }
}

TEST(Bindings, every_row_is_documented) {
  const std::string text =
      read_text_file(std::filesystem::path(QUADSPLAT_SOURCE_DIR) / "docs/viewer.md", 1 << 20);
  for (const Binding& row : bindings()) {
    // Markdown shows a backtick between two of them.
    const std::string key = key_name(row.key, row.mods);
    const std::string quoted = key == "`" ? "`` ` ``" : "`" + key + "`";
    EXPECT_THAT(text, HasSubstr("| " + quoted + " | " + row.help + " |"));
  }
  for (const Gesture& gesture : gestures())
    EXPECT_THAT(text, HasSubstr(std::string("| ") + gesture.keys + " | " + gesture.help + " |"));
  for (const ScriptCommand& command : kScriptCommands)
    EXPECT_THAT(text, HasSubstr(std::string("`") + command.name));
}

TEST(Input, drags_mean_what_the_navigation_says) {
  Input input;
  Actions actions;
  input.cursor({100, 100}, Navigation::orbit, actions);
  EXPECT_THAT(actions, IsEmpty());
  const auto drag = [&](int button, Navigation navigation) {
    actions.clear();
    input.button(button, true, false, 10.0 * button + 100 * static_cast<int>(navigation), actions);
    input.cursor(input.cursor() + glm::dvec2(10, 5), navigation, actions);
    input.button(button, false, false, 0, actions);
    return actions.size() == 1 ? actions[0].index() : std::variant_npos;
  };
  EXPECT_EQ(drag(GLFW_MOUSE_BUTTON_LEFT, Navigation::orbit), Action(Orbit{}).index());
  EXPECT_EQ(drag(GLFW_MOUSE_BUTTON_RIGHT, Navigation::orbit), Action(Pan{}).index());
  EXPECT_EQ(drag(GLFW_MOUSE_BUTTON_MIDDLE, Navigation::orbit), Action(Pan{}).index());
  EXPECT_EQ(drag(GLFW_MOUSE_BUTTON_LEFT, Navigation::fly), Action(Look{}).index());
  EXPECT_EQ(drag(GLFW_MOUSE_BUTTON_RIGHT, Navigation::fly), Action(Look{}).index());
}

TEST(Input, panels_and_text_fields_swallow) {
  Input input;
  Actions actions;
  input.key(GLFW_KEY_H, true, false, 0, true, actions);
  input.wheel(1, 0, true, actions);
  input.button(GLFW_MOUSE_BUTTON_LEFT, true, true, 0, actions);
  input.cursor({5, 5}, Navigation::orbit, actions);
  input.tick(0.1, actions);
  EXPECT_THAT(actions, IsEmpty());
  EXPECT_FALSE(input.busy());
}

TEST(Input, held_keys_fly_until_they_are_released_or_the_focus_is_lost) {
  Input input;
  Actions actions;
  input.key(GLFW_KEY_W, true, false, 0, false, actions);
  input.key(GLFW_KEY_D, true, false, GLFW_MOD_SHIFT, false, actions);
  input.tick(0.5, actions);
  ASSERT_THAT(actions, SizeIs(1));
  const Fly fly = std::get<Fly>(actions[0]);
  EXPECT_EQ(fly.direction, glm::dvec3(1, 0, 1));
  EXPECT_EQ(fly.factor, 5);
  actions.clear();
  input.release_all(actions);
  input.tick(0.5, actions);
  EXPECT_THAT(actions, IsEmpty());
  EXPECT_FALSE(input.busy());
}

TEST(Input, the_previous_mode_shows_while_its_key_is_held) {
  Input input;
  Actions actions;
  input.key(GLFW_KEY_GRAVE_ACCENT, true, false, 0, false, actions);
  input.key(GLFW_KEY_GRAVE_ACCENT, true, true, 0, false, actions);
  ASSERT_THAT(actions, SizeIs(1));
  EXPECT_TRUE(std::get<PeekPreviousMode>(actions[0]).held);
  input.release_all(actions);
  ASSERT_THAT(actions, SizeIs(2));
  EXPECT_FALSE(std::get<PeekPreviousMode>(actions[1]).held);
}

TEST(Input, two_quick_clicks_in_place_pick_the_pivot) {
  Input input;
  Actions actions;
  const auto click = [&](double now) {
    input.button(GLFW_MOUSE_BUTTON_LEFT, true, false, now, actions);
    input.button(GLFW_MOUSE_BUTTON_LEFT, false, false, now, actions);
  };
  const auto picks = [&] {
    return std::count_if(actions.begin(), actions.end(), [](const Action& action) {
      return std::holds_alternative<PickPivot>(action);
    });
  };
  click(1);
  click(2);
  EXPECT_EQ(picks(), 0);
  click(2.2);
  ASSERT_EQ(picks(), 1);
  click(2.3);  // a third click does not pick again
  EXPECT_EQ(picks(), 1);
}

TEST(Input, a_click_that_does_not_drag_inspects_its_pixel) {
  Input input;
  Actions actions;
  input.cursor({40, 30}, Navigation::orbit, actions);
  input.button(GLFW_MOUSE_BUTTON_LEFT, true, false, 1, actions);
  EXPECT_THAT(actions, IsEmpty());
  input.button(GLFW_MOUSE_BUTTON_LEFT, false, false, 1, actions);
  ASSERT_THAT(actions, SizeIs(1));
  EXPECT_EQ(std::get<InspectPixel>(actions[0]).pixel, glm::dvec2(40, 30));
}

TEST(Viewer, clicks_ask_for_an_inspection_only_inside_the_picture_and_with_the_inspector_open) {
  Viewer viewer = viewer_with(2);
  const glm::dvec2 inside(5, 5), outside(viewer.camera.width, 5);
  apply(viewer, InspectPixel{inside});
  EXPECT_THAT(viewer.requests, IsEmpty());
  apply(viewer, TogglePanel{&Panels::inspector});
  apply(viewer, InspectPixel{outside});
  apply(viewer, InspectGaussian{3});  // nothing is inspected yet
  EXPECT_THAT(viewer.requests, IsEmpty());
  apply(viewer, InspectPixel{inside});
  ASSERT_THAT(viewer.requests, SizeIs(1));
  EXPECT_EQ(std::get<request::Inspect>(viewer.requests[0]).gaussian, std::nullopt);

  InspectedView view;
  view.version = viewer.version;
  view.inspection.pixel.pixel = {5, 5};
  apply(viewer, PixelInspected{view});
  apply(viewer, InspectGaussian{3});
  ASSERT_THAT(viewer.requests, SizeIs(2));
  EXPECT_EQ(std::get<request::Inspect>(viewer.requests[1]).gaussian, 3u);
  EXPECT_EQ(std::get<request::Inspect>(viewer.requests[1]).pixel, inside);
  apply(viewer, GoHome{});
  apply(viewer, ChangeFov{1});
  apply(viewer, InspectGaussian{4});  // of an earlier view
  EXPECT_THAT(viewer.requests, SizeIs(2));
}

TEST(Viewer, keeps_and_says_what_the_reference_says) {
  Viewer viewer = viewer_with(2);
  apply(viewer, AskOracle{});
  ASSERT_THAT(viewer.requests, SizeIs(1));
  EXPECT_TRUE(std::holds_alternative<request::AskOracle>(viewer.requests[0]));
  apply(viewer, OracleAnswered{{viewer.version, {}, "quadbox: equal"}});
  EXPECT_EQ(viewer.oracle->sentence, "quadbox: equal");
  EXPECT_EQ(viewer.toasts.back().text, "quadbox: equal");
}

TEST(Input, modifiers_change_the_wheel) {
  Input input;
  Actions actions;
  input.wheel(1, 0, false, actions);
  input.wheel(1, GLFW_MOD_SHIFT, false, actions);
  input.wheel(1, GLFW_MOD_CONTROL, false, actions);
  ASSERT_THAT(actions, SizeIs(3));
  EXPECT_EQ(actions[0].index(), Action(Dolly{}).index());
  EXPECT_EQ(actions[1].index(), Action(ChangeFov{}).index());
  EXPECT_EQ(actions[2].index(), Action(Roll{}).index());
}

// ---- what is kept, what is read
// ------------------------------------------------------------------
TEST(Preferences, are_read_back) {
  const TemporaryFolder folder;
  Preferences written;
  written.width = 1600;
  written.vsync = false;
  written.navigation = Navigation::fly;
  written.recent = {"/a.ply", "/b c.ply"};
  written.cameras["/a.ply"] = "{}";
  write_preferences(folder / "deep/viewer.json", written);
  std::string problem;
  const Preferences read = read_preferences(folder / "deep/viewer.json", problem);
  EXPECT_EQ(problem, "");
  EXPECT_EQ(read.width, 1600);
  EXPECT_FALSE(read.vsync);
  EXPECT_EQ(read.navigation, Navigation::fly);
  EXPECT_EQ(read.recent, written.recent);
  EXPECT_EQ(read.cameras, written.cameras);
}

TEST(Preferences, damaged_ones_are_reported_and_ignored) {
  const TemporaryFolder folder;
  for (const char* text : {"{", "[]", "{\"width\": \"wide\"}", "{\"recent\": 3}"}) {
    std::ofstream(folder / "viewer.json") << text;
    std::string problem;
    const Preferences read = read_preferences(folder / "viewer.json", problem);
    EXPECT_EQ(read.width, Preferences().width);
    EXPECT_THAT(problem, HasSubstr("ignored")) << text;
  }
  std::string problem;
  read_preferences(folder / "missing.json", problem);
  EXPECT_EQ(problem, "");
}

TEST(Resolution, is_whole_when_quick_and_bounded_when_slow) {
  EXPECT_EQ(resolution_divisor(0, 1280, 720), 1);
  EXPECT_EQ(resolution_divisor(20, 1280, 720), 1);
  EXPECT_EQ(resolution_divisor(200, 1280, 720), 3);
  EXPECT_EQ(resolution_divisor(1e9, 1280, 720), kMostDivisor);
}

TEST(InputScript, names_the_line_that_is_wrong) {
  const TemporaryFolder folder;
  const auto error_of = [&](const char* text) -> std::string {
    std::ofstream(folder / "script") << text;
    try {
      read_script(folder / "script");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(error_of("# nothing\n\nkey H\nwait\nwheel -2 Ctrl\ndrop a file.ply\n"), "");
  EXPECT_THAT(error_of("wait\njump\n"), HasSubstr("line 2: there is no command 'jump'"));
  EXPECT_THAT(error_of("move 3\n"), HasSubstr("line 1: it is 'move X Y'"));
}

TEST(SceneFacts, up_is_the_cameras_mean_unless_the_file_says_so) {
  Scene scene;
  scene.path = "/nowhere/scene.ply";
  scene.cloud = test::random_cloud(50, 0, 1);
  EXPECT_EQ(view_facts(scene, std::nullopt).up, glm::dvec3(0, -1, 0));
  scene.vertical_axis = "z";
  EXPECT_EQ(view_facts(scene, std::nullopt).up, glm::dvec3(0, 0, 1));
}

}  // namespace
}  // namespace qs
