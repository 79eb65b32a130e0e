// SPDX-License-Identifier: MIT
//
// The viewer's state without a window: actions, the table of commands, input.
#include <map>
#include <set>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/camera_control.h"
#include "app/support/driven_viewer.h"
#include "app/viewer/commands/commands.h"
#include "app/viewer/commands/input.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/commands/keys.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/zoom_actions.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/cloud/axes.h"
#include "support/paths.h"

namespace qs {
namespace {

using test::Driven;
using test::DrivenScene;
using test::some_scene;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using namespace action;

// ---- actions -----------------------------------------------------------------------------------
TEST(Viewer, opens_at_the_first_camera_in_the_window_s_size) {
  const DrivenScene driven(3);
  const Viewer& viewer = driven.viewer;
  EXPECT_EQ(viewer.dataset_camera, 0);
  EXPECT_EQ(viewer.camera.width, 640);
  EXPECT_EQ(viewer.camera.height, 480);
  EXPECT_LT(glm::distance(viewer.camera.position(), viewer.scene->cameras[0].position()), 1e-12);
  EXPECT_LT(glm::length(viewer.pivot), 0.1);  // the cameras look at the origin
}

TEST(Viewer, frames_a_scene_without_cameras_upright) {
  const DrivenScene driven(0);
  EXPECT_EQ(driven.viewer.dataset_camera, -1);
  EXPECT_GT(depth_of(driven.viewer.camera, glm::dvec3(0)), 1);
  EXPECT_GT(view_axes(driven.viewer.camera).down.y, 0.5);
}

TEST(Viewer, switches_modes_and_back) {
  DrivenScene driven(1);
  const Viewer& viewer = driven.viewer;
  const int version = viewer.version, view_version = viewer.view_version;
  driven.press("2");
  EXPECT_EQ(viewer.mode(), 2);
  EXPECT_GT(viewer.version, version);
  EXPECT_EQ(viewer.view_version, view_version);  // the numbers of all modes stay valid
  driven.apply(peek_previous_mode, true);
  EXPECT_EQ(viewer.mode(), default_mode());
  driven.apply(peek_previous_mode, false);
  EXPECT_EQ(viewer.mode(), 2);
  driven.apply(set_mode, 99);
  EXPECT_EQ(viewer.mode(), 2);
}

TEST(Viewer, heat_maps_toggle_and_take_turns) {
  DrivenScene driven(1);
  const Viewer& viewer = driven.viewer;
  driven.press("H");
  EXPECT_EQ(viewer.heatmap, HeatQuantity::pairs);
  driven.press("Shift+H");
  EXPECT_EQ(viewer.heatmap, HeatQuantity::evaluated);
  driven.press("H");
  EXPECT_EQ(viewer.heatmap, std::nullopt);
  driven.press("H");
  EXPECT_EQ(viewer.heatmap, HeatQuantity::evaluated);
}

TEST(Viewer, depth_and_alpha_take_turns_and_replace_heat_maps) {
  DrivenScene driven(1);
  const Viewer& viewer = driven.viewer;
  driven.press("H");
  const int version = viewer.version;
  driven.press("J");
  EXPECT_EQ(viewer.quantity, Quantity::depth);
  EXPECT_EQ(viewer.heatmap, std::nullopt);
  EXPECT_GT(viewer.version, version);
  for (const Quantity next : {Quantity::median_depth, Quantity::alpha, Quantity::depth}) {
    driven.press("Shift+J");
    EXPECT_EQ(viewer.quantity, next);
  }
  driven.press("Shift+J");
  driven.press("J");
  EXPECT_EQ(viewer.quantity, Quantity::color);
  driven.press("Shift+J");
  EXPECT_EQ(viewer.quantity, Quantity::median_depth) << "the last one comes back";
  driven.press("H");
  EXPECT_EQ(viewer.quantity, Quantity::color);
  EXPECT_TRUE(viewer.heatmap);
}

TEST(Viewer, splats_grow_by_a_tenth_and_come_back_to_exactly_one) {
  DrivenScene driven(1);
  driven.press("=");
  EXPECT_FLOAT_EQ(driven.viewer.settings.splat_scale, 1.1f);
  driven.press("-");
  EXPECT_EQ(driven.viewer.settings.splat_scale, 1);
  for (int i = 0; i < 100; ++i) driven.press("-");
  EXPECT_FLOAT_EQ(driven.viewer.settings.splat_scale, 0.01f);
}

TEST(Viewer, opens_a_scene_beside_and_closes_it_with_the_same_key) {
  DrivenScene driven(0);
  const Viewer& viewer = driven.viewer;
  driven.press("Ctrl+Shift+O");
  EXPECT_TRUE(viewer.panels.open);
  driven.apply(path_chosen, std::filesystem::path("/data/other.ply"), viewer.choosing);
  EXPECT_EQ(driven.opened_beside, std::vector<std::filesystem::path>{"/data/other.ply"});
  EXPECT_TRUE(driven.opened.empty());
  const int version = viewer.version;
  driven.apply(beside_opened, SceneBeside{"/data/other.ply", 70});
  EXPECT_TRUE(viewer.panels.split);
  EXPECT_GT(viewer.version, version);
  EXPECT_EQ(viewer.recent.front(), "/data/other.ply");
  EXPECT_EQ(viewer.scene->name, "garden");
  driven.press("Ctrl+Shift+O");
  EXPECT_FALSE(viewer.beside);
  EXPECT_FALSE(viewer.panels.split);
  EXPECT_EQ(driven.jobs.size(), 1u) << "which frees the other scene";
}

TEST(Viewer, opens_dropped_files_and_those_of_the_usual_dialog_as_the_scene) {
  DrivenScene driven(0);
  driven.press("Ctrl+Shift+O");
  driven.apply(open, std::filesystem::path("/data/dropped.ply"));  // the dialog is still open
  driven.press("Ctrl+Shift+O");                                    // closes it
  driven.press("Ctrl+O");
  driven.apply(path_chosen, std::filesystem::path("/data/chosen.ply"), driven.viewer.choosing);
  ASSERT_EQ(driven.opened.size(), 2u);
  EXPECT_EQ(driven.opened[0].path, "/data/dropped.ply");
  EXPECT_EQ(driven.opened[1].path, "/data/chosen.ply");
  EXPECT_TRUE(driven.opened_beside.empty());
}

TEST(Viewer, splits_the_window_with_a_variant_that_differs) {
  DrivenScene driven(0);
  const Viewer& viewer = driven.viewer;
  driven.apply(set_mode, find_culler("adr"));
  Split split = viewer.split;
  split.other = viewer.variant();
  driven.apply(change_split, split);
  const int before = viewer.version;
  driven.press("C");
  EXPECT_TRUE(viewer.panels.split);
  EXPECT_NE(viewer.split.other, viewer.variant());
  EXPECT_GT(viewer.version, before);
  // Another way to show both needs no new frame, another variant does.
  const int shown = viewer.version;
  driven.press("X");
  EXPECT_TRUE(viewer.split.flipped);
  for (int i = 0; i < 4; ++i) driven.press("Shift+C");
  EXPECT_EQ(viewer.split.view, SplitView::sides);
  EXPECT_EQ(viewer.version, shown);
  split = viewer.split;
  split.other.mode = kReferenceMode;
  driven.apply(change_split, split);
  EXPECT_GT(viewer.version, shown);
}

TEST(Viewer, goes_through_all_axes_and_back_to_the_file_s) {
  DrivenScene driven(0);
  std::set<std::string> seen;
  constexpr std::size_t kFrames = 9;
  for (std::size_t i = 0; i <= kFrames; ++i) {
    driven.press("Y");
    ASSERT_THAT(driven.opened, SizeIs(i + 1));
    seen.insert(driven.opened.back().axes);
    ViewedScene scene = some_scene(0);
    scene.axes = driven.opened.back().axes;
    driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
  }
  EXPECT_EQ(driven.viewer.scene->axes, "");
  EXPECT_EQ(seen.size(), kFrames + 1);
}

TEST(Viewer, steps_through_cameras_and_leaves_them_by_moving) {
  DrivenScene driven(4);
  const Viewer& viewer = driven.viewer;
  driven.press("[");
  EXPECT_EQ(viewer.dataset_camera, 3);
  driven.press("]");
  EXPECT_EQ(viewer.dataset_camera, 0);
  driven.press("Shift+]");
  EXPECT_EQ(viewer.dataset_camera, 3);
  driven.apply(orbit, glm::dvec2(3, 2));
  EXPECT_EQ(viewer.dataset_camera, -1);
  driven.press("N");
  EXPECT_EQ(viewer.dataset_camera, 3);
  driven.press("Shift+[");
  EXPECT_EQ(viewer.dataset_camera, 0);
}

TEST(Viewer, says_so_when_there_are_no_cameras) {
  DrivenScene driven(0);
  driven.press("]");
  ASSERT_THAT(driven.viewer.toasts, SizeIs(1));
  EXPECT_THAT(driven.viewer.toasts[0].text, HasSubstr("cameras.json"));
  driven.apply(tick, Turn{100}, 0.1);
  EXPECT_THAT(driven.viewer.toasts, IsEmpty());
}

TEST(Viewer, resizing_keeps_the_vertical_field_of_view) {
  DrivenScene driven(2);
  const double fov = vertical_fov(driven.viewer.camera);
  driven.apply(resize, 1920, 1080);
  EXPECT_NEAR(vertical_fov(driven.viewer.camera), fov, 1e-12);
  EXPECT_EQ(driven.viewer.camera.width, 1920);
  EXPECT_EQ(driven.viewer.dataset_camera, 0);
}

TEST(Viewer, a_failed_load_keeps_the_scene_and_shows_the_sentence) {
  DrivenScene driven(1);
  driven.apply(action::open, std::filesystem::path("/data/broken.ply"));
  ASSERT_THAT(driven.opened, SizeIs(1));
  EXPECT_EQ(driven.opened[0].path, "/data/broken.ply");
  driven.apply(show_progress, Loading{"/data/broken.ply", "reading", 0.5f});
  driven.apply(opening_ended, OpeningResult(OpeningFailed{"/data/broken.ply: is not a ply file"}));
  driven.apply(end_progress);
  EXPECT_EQ(driven.viewer.scene->name, "garden");
  EXPECT_FALSE(driven.viewer.loading);
  EXPECT_TRUE(driven.viewer.toasts.back().error);
}

TEST(Viewer, an_error_of_an_action_becomes_a_sentence_and_changes_nothing_else) {
  DrivenScene driven(1);
  const int version = driven.viewer.version;
  driven.text = "nonsense";
  driven.press("Ctrl+V");
  ASSERT_THAT(driven.viewer.toasts, SizeIs(1));
  EXPECT_TRUE(driven.viewer.toasts[0].error);
  EXPECT_THAT(driven.viewer.toasts[0].text, HasSubstr("clipboard"));
  EXPECT_EQ(driven.viewer.version, version);
}

TEST(Viewer, a_copied_camera_is_pasted_exactly) {
  DrivenScene driven(3);
  driven.press("]");
  const std::string camera = format_camera(driven.viewer.camera);
  driven.press("Ctrl+C");
  driven.press("Home");
  EXPECT_NE(format_camera(driven.viewer.camera), camera);
  driven.press("Ctrl+V");
  EXPECT_EQ(format_camera(driven.viewer.camera), camera);
}

TEST(Viewer, reopening_a_scene_keeps_the_view) {
  DrivenScene driven(2);
  driven.apply(orbit, glm::dvec2(50, 20));
  const glm::dvec3 position = driven.viewer.camera.position();
  driven.apply(scene_opened, OpenedScene{some_scene(2), RenderSettings(), Backend::cpu});
  EXPECT_EQ(driven.viewer.camera.position(), position);
}

TEST(Viewer, a_scene_opens_where_it_was_left_unless_cameras_were_named) {
  for (const bool restores : {true, false}) {
    DrivenScene driven(2);
    driven.apply([&](Viewer& viewer) { viewer.restores_views = restores; });
    driven.apply(orbit, glm::dvec2(50, 20));
    const std::string left = format_camera(driven.viewer.camera);
    ViewedScene other = some_scene(1);
    other.path = "/data/other.ply";
    driven.apply(scene_opened, OpenedScene{other, RenderSettings(), Backend::cpu});
    EXPECT_EQ(driven.viewer.dataset_camera, 0);
    driven.apply(scene_opened, OpenedScene{some_scene(2), RenderSettings(), Backend::cpu});
    EXPECT_EQ(format_camera(driven.viewer.camera) == left, restores);
    EXPECT_EQ(driven.viewer.dataset_camera, restores ? -1 : 0);
    EXPECT_EQ(driven.viewer.toasts.size(), restores ? 1u : 0u);
  }
}

TEST(Viewer, a_kept_view_that_cannot_be_read_leaves_the_first_view) {
  Driven driven;
  driven.apply([](Viewer& viewer) { viewer.last_views["/data/garden.ply"] = "{}"; });
  driven.apply(resize, 640, 480);
  driven.apply(scene_opened, OpenedScene{some_scene(2), RenderSettings(), Backend::cpu});
  EXPECT_EQ(driven.viewer.dataset_camera, 0);
  EXPECT_THAT(driven.viewer.toasts, IsEmpty());
}

TEST(Viewer, recent_files_are_unique_newest_first) {
  Driven driven;
  driven.apply(resize, 640, 480);
  for (const char* path : {"/a.ply", "/b.ply", "/a.ply"}) {
    ViewedScene scene = some_scene(0);
    scene.path = path;
    driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
  }
  EXPECT_THAT(driven.viewer.recent, testing::ElementsAre("/a.ply", "/b.ply"));
}

TEST(Viewer, reads_a_camera_s_photograph_once_and_drops_one_that_comes_late) {
  Driven driven;
  driven.apply(resize, 640, 480);
  ViewedScene scene = some_scene(3);
  scene.photographs = {{0, "/0.jpg"}, {2, "/2.jpg"}};
  driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
  EXPECT_THAT(driven.photographs, IsEmpty());
  driven.press("G");
  driven.press("Home");
  EXPECT_THAT(driven.photographs, testing::ElementsAre("/0.jpg"));
  driven.press("]");  // without a photograph
  driven.press("]");
  EXPECT_THAT(driven.photographs, testing::ElementsAre("/0.jpg", "/2.jpg"));
  const auto image = std::make_shared<Image>(4, 3, 3);
  driven.apply(photograph_opened, ShownPhotograph{"/0.jpg", image});
  EXPECT_EQ(driven.viewer.photograph.image, nullptr);
  driven.apply(photograph_opened, ShownPhotograph{"/2.jpg", image});
  EXPECT_EQ(driven.viewer.photograph.image, image);
}

TEST(Viewer, keyframes_play_along_their_path) {
  DrivenScene driven(0);
  const Viewer& viewer = driven.viewer;
  driven.press("Space");
  EXPECT_FALSE(viewer.playback.running);  // nothing to play
  driven.press("K");
  const Camera first = viewer.camera;
  driven.apply(orbit, glm::dvec2(200, 0));
  driven.press("K");
  const Camera second = viewer.camera;
  driven.press("Space");
  driven.press("Space");
  driven.apply(seek, 0.0);
  EXPECT_LT(glm::distance(viewer.camera.position(), first.position()), 1e-9);
  driven.press("Space");
  for (int i = 0; i < 20; ++i) driven.apply(tick, Turn{0.1 * i}, 0.1);
  EXPECT_FALSE(viewer.playback.running);
  EXPECT_LT(glm::distance(viewer.camera.position(), second.position()), 1e-9);
  driven.apply(remove_keyframe, std::size_t{7});
  EXPECT_THAT(viewer.keyframes, SizeIs(2));
  driven.apply(save_keyframes);
  EXPECT_EQ(driven.written["./garden_path.json"], format_camera_path(viewer.keyframes));
}

TEST(Viewer, clicks_start_an_inspection_only_inside_the_picture_and_with_the_inspector_open) {
  DrivenScene driven(2);
  const glm::dvec2 inside(5, 5), outside(driven.viewer.camera.width, 5);
  driven.apply(action::inspect_pixel, inside);
  EXPECT_THAT(driven.jobs, IsEmpty());
  driven.press("B");
  driven.apply(action::inspect_pixel, outside);
  driven.apply(action::inspect_gaussian, 3u);  // nothing is inspected yet
  EXPECT_THAT(driven.jobs, IsEmpty());
  driven.apply(action::inspect_pixel, inside);
  EXPECT_THAT(driven.jobs, SizeIs(1));
  InspectedView view;
  view.version = driven.viewer.version;
  driven.apply(pixel_inspected, view);
  driven.apply(action::inspect_gaussian, 3u);
  EXPECT_THAT(driven.jobs, SizeIs(2));
  driven.apply(change_fov, 1.0);
  driven.apply(action::inspect_gaussian, 4u);  // of an earlier view
  EXPECT_THAT(driven.jobs, SizeIs(2));
}

TEST(Viewer, keeps_and_says_what_the_reference_says) {
  DrivenScene driven(2);
  driven.press("0");
  driven.press("Shift+0");
  EXPECT_THAT(driven.jobs, SizeIs(2));
  ReferenceComparison comparison;
  comparison.view_version = driven.viewer.view_version;
  comparison.variant = driven.viewer.variant();
  comparison.sentence = "quadbox: equal";
  driven.apply(compared_with_reference, comparison);
  EXPECT_EQ(driven.viewer.comparison->sentence, "quadbox: equal");
  EXPECT_THAT(driven.viewer.toasts, IsEmpty()) << "its panel says it";
  driven.apply(dismiss_comparison);
  EXPECT_FALSE(driven.viewer.comparison);
  // A sentence gives the result if the panel cannot, because the panel is hidden or the view has
  // changed.
  driven.press("Tab");
  driven.apply(compared_with_reference, comparison);
  EXPECT_EQ(driven.viewer.toasts.back().text, "quadbox: equal");
  driven.press("Tab");
  driven.apply(orbit, glm::dvec2(1, 1));
  comparison.sentence = "of an earlier view";
  driven.apply(compared_with_reference, comparison);
  EXPECT_EQ(driven.viewer.toasts.back().text, "of an earlier view");
}

TEST(Viewer, jobs_wait_for_a_scene_and_the_zoom_s_key_stops_it_too) {
  Driven empty;
  for (const char* key : {"Shift+Z", "P", "0", "Shift+0", "Ctrl+F12", "F12", "F5", "Y"})
    empty.press(key);
  EXPECT_THAT(empty.jobs, IsEmpty());
  EXPECT_THAT(empty.grabs, IsEmpty());
  EXPECT_THAT(empty.opened, IsEmpty());
  DrivenScene driven(1);
  driven.press("Z");
  EXPECT_TRUE(driven.viewer.panels.recorder);
  driven.press("Z");
  EXPECT_FALSE(driven.viewer.panels.recorder);
  EXPECT_THAT(driven.jobs, IsEmpty()) << "Z opens and closes the panel and nothing else";
  for (int times = 0; times < 2; ++times) driven.press("Shift+Z");
  EXPECT_THAT(driven.jobs, SizeIs(1)) << "a double click records once";
  EXPECT_FALSE(driven.viewer.panels.recorder) << "the picture keeps its size";
  EXPECT_EQ(driven.viewer.toasts.size(), 1u);
  driven.apply(zoom_began, ZoomRecord());
  driven.press("Z");
  EXPECT_TRUE(driven.viewer.zoom.running);
  EXPECT_EQ(driven.stopped, 0);
  driven.press("Shift+Z");
  EXPECT_EQ(driven.stopped, 1);
  EXPECT_THAT(driven.jobs, SizeIs(1));
}

// ---- keys and mouse ----------------------------------------------------------------------------
TEST(Commands, no_key_does_two_things) {
  std::set<std::pair<int, int>> keys;
  std::set<std::string> helps;
  for (const KeyCommand& row : key_commands()) {
    EXPECT_TRUE(keys.emplace(row.key, row.mods).second) << row.help;
    EXPECT_TRUE(helps.insert(row.help).second) << row.help;
    EXPECT_NE(row.help, "");
    EXPECT_TRUE(row.action) << row.help;
  }
  for (const FlyKey& row : fly_keys()) EXPECT_TRUE(keys.emplace(row.key, 0).second) << row.help;
}

TEST(Commands, menus_without_a_scene_offer_what_acts_without_one_and_files_end_with_quit) {
  std::vector<std::string> without, files;
  for (const KeyCommand& row : key_commands()) {
    if (row.without_scene) without.push_back(row.help);
    if (row.menu == Menu::file) files.push_back(row.help);
    EXPECT_EQ(row.line_above, row.help == "Quit") << row.help;
  }
  EXPECT_THAT(without, testing::UnorderedElementsAre(
                           "Open a file", "Train from photographs", "Quit", "All windows",
                           "Full screen", "Keys and mouse", "Larger interface", "Smaller interface",
                           "Interface at 100 %", "Light theme", "Find a command by words"));
  EXPECT_EQ(files.front(), "Open a file");
  EXPECT_EQ(files.back(), "Quit");
  EXPECT_EQ(std::string(kMenuNames[static_cast<int>(Menu::help)]), "Help");
  EXPECT_EQ(find_key_command(GLFW_KEY_F1, 0)->menu, Menu::help);
}

TEST(Commands, view_has_at_most_a_dozen_entries_and_what_measures_is_in_measure) {
  std::map<Menu, int> entries;
  for (const KeyCommand& row : key_commands()) ++entries[row.menu];
  EXPECT_LE(entries[Menu::view], 12);
  for (const char* help : {"FPS of all modes", "Heat map", "Zoom recorder", "Bench this view"})
    EXPECT_EQ(std::ranges::find(key_commands(), help, &KeyCommand::help)->menu, Menu::measure);
  EXPECT_EQ(menu_label(*find_key_command(GLFW_KEY_O, GLFW_MOD_CONTROL)), "Open a file ...");
}

TEST(Commands, are_found_by_words_of_their_menu_name_and_key) {
  const auto found = [](const std::string& text, const Viewer& viewer) {
    std::vector<std::string> helps;
    for (const KeyCommand* row : find_commands(text, viewer)) helps.push_back(row->help);
    return helps;
  };
  const DrivenScene driven(1);
  EXPECT_THAT(found("ctrl+q", driven.viewer), testing::ElementsAre("Quit"));
  EXPECT_THAT(found("ZOOM measure record", driven.viewer), testing::Contains("Record a zoom"));
  EXPECT_THAT(found("no such words", driven.viewer), IsEmpty());
  EXPECT_GT(found("", driven.viewer).size(), 50u);
  EXPECT_THAT(found("", driven.viewer),
              testing::Not(testing::Contains("Previous mode, while held")));
  EXPECT_THAT(found("heat", Viewer()), IsEmpty()) << "it needs a scene";
}

TEST(Commands, names_of_keys_are_read_back) {
  for (const KeyCommand& row : key_commands()) {
    const KeyPress press = parse_key(key_name(row.key, row.mods));
    EXPECT_EQ(press.key, row.key) << key_name(row.key, row.mods);
    EXPECT_EQ(press.mods, row.mods);
  }
}

TEST(Commands, every_mode_has_its_digit_in_both_rows_and_a_tick_while_it_is_chosen) {
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    for (const int zero : {GLFW_KEY_0, GLFW_KEY_KP_0}) {
      DrivenScene driven(1);
      const KeyCommand* row = find_key_command(zero + mode, 0);
      ASSERT_NE(row, nullptr);
      driven.store.apply(row->action, driven);
      EXPECT_EQ(driven.viewer.mode(), mode);
      EXPECT_EQ(row->menu, Menu::mode);
      EXPECT_TRUE(row->is_checked(driven.viewer));
      driven.press(mode == 1 ? "2" : "1");
      EXPECT_FALSE(row->is_checked(driven.viewer));
    }
  }
}

TEST(Commands, every_row_is_documented) {
  const std::string text = read_text_file(test::source_path("docs/viewer.md"), 1 << 20);
  for (const KeyCommand& row : key_commands()) {
    // Markdown needs two backticks around one.
    const std::string key = key_name(row.key, row.mods);
    const std::string quoted = key == "`" ? "`` ` ``" : "`" + key + "`";
    EXPECT_THAT(text, HasSubstr("| " + quoted + " | " + row.help + " |"));
  }
  for (const Gesture& gesture : gestures())
    EXPECT_THAT(text, HasSubstr(std::string("| ") + gesture.keys + " | " + gesture.help + " |"));
  for (const PadControl& control : pad_controls()) {
    EXPECT_THAT(text, HasSubstr(std::string("| ") + control.keys + " | " + control.help + " |"));
    EXPECT_EQ(find_command(control.help) != nullptr, control.button >= 0) << control.help;
  }
}

TEST(Input, drags_mean_what_the_navigation_says) {
  // The camera after a drag with the mouse, and after the expected action.
  const auto dragged = [](int button, Navigation navigation) {
    DrivenScene driven(1);
    Input input;
    Actions actions;
    input.cursor({100, 100}, navigation, actions);
    EXPECT_THAT(actions, IsEmpty());
    input.button(button, true, false, 1, actions);
    input.cursor({110, 105}, navigation, actions);
    input.button(button, false, false, 1, actions);
    int moves = 0;  // the other actions are for a selecting tool, which is not chosen
    for (const Action& action : actions) {
      const std::string before = format_camera(driven.viewer.camera);
      driven.apply_all({action});
      moves += format_camera(driven.viewer.camera) != before;
    }
    EXPECT_EQ(moves, 1);
    EXPECT_THAT(driven.jobs, IsEmpty());
    return format_camera(driven.viewer.camera);
  };
  const auto moved = [](void (*motion)(Viewer&, glm::dvec2)) {
    DrivenScene driven(1);
    driven.apply(motion, glm::dvec2(10, 5));
    return format_camera(driven.viewer.camera);
  };
  EXPECT_EQ(dragged(GLFW_MOUSE_BUTTON_LEFT, Navigation::orbit), moved(orbit));
  EXPECT_EQ(dragged(GLFW_MOUSE_BUTTON_RIGHT, Navigation::orbit), moved(pan));
  EXPECT_EQ(dragged(GLFW_MOUSE_BUTTON_MIDDLE, Navigation::orbit), moved(pan));
  EXPECT_EQ(dragged(GLFW_MOUSE_BUTTON_MIDDLE, Navigation::fly), moved(pan));
  EXPECT_EQ(dragged(GLFW_MOUSE_BUTTON_LEFT, Navigation::fly), moved(look));
  EXPECT_EQ(dragged(GLFW_MOUSE_BUTTON_RIGHT, Navigation::fly), moved(look));
}

TEST(Input, modifiers_change_the_wheel) {
  const auto turned = [](int mods) {
    DrivenScene driven(1);
    Input input;
    Actions actions;
    input.wheel(1, mods, false, actions);
    driven.apply_all(actions);
    return format_camera(driven.viewer.camera);
  };
  const auto moved = [](void (*motion)(Viewer&, double)) {
    DrivenScene driven(1);
    driven.apply(motion, 1.0);
    return format_camera(driven.viewer.camera);
  };
  EXPECT_EQ(turned(0), moved(action::turn_wheel));
  EXPECT_EQ(turned(GLFW_MOD_SHIFT), moved(change_fov));
  EXPECT_EQ(turned(GLFW_MOD_CONTROL), moved(roll));
}

TEST(Input, a_drag_that_turns_a_flying_camera_looks_around) {
  Input input;
  Actions actions;
  EXPECT_FALSE(input.looks_around(Navigation::fly));
  for (const int button :
       {GLFW_MOUSE_BUTTON_LEFT, GLFW_MOUSE_BUTTON_RIGHT, GLFW_MOUSE_BUTTON_MIDDLE}) {
    input.button(button, true, false, 0, actions);
    EXPECT_EQ(input.looks_around(Navigation::fly), button != GLFW_MOUSE_BUTTON_MIDDLE);
    EXPECT_FALSE(input.looks_around(Navigation::orbit));
    input.button(button, false, false, 0, actions);
    EXPECT_FALSE(input.looks_around(Navigation::fly));
  }
  input.button(GLFW_MOUSE_BUTTON_LEFT, true, true, 0, actions);
  EXPECT_FALSE(input.looks_around(Navigation::fly)) << "a panel has the mouse";
}

TEST(Input, panels_and_text_fields_swallow) {
  Input input;
  Actions actions;
  input.key(GLFW_KEY_H, true, false, 0, true, actions);
  input.wheel(1, 0, true, actions);
  input.button(GLFW_MOUSE_BUTTON_LEFT, true, true, 0, actions);
  input.cursor({5, 5}, Navigation::orbit, actions);
  input.tick(actions);
  EXPECT_THAT(actions, IsEmpty());
  EXPECT_FALSE(input.busy());
}

TEST(Input, keys_do_nothing_else_while_the_dialog_open_takes_them) {
  DrivenScene driven(1);
  Input input;
  Actions actions;
  const auto type = [&](int key, int mods) {
    input.key(key, true, false, mods, false, actions);
    input.key(key, false, false, mods, false, actions);
  };
  // All in one poll, before the dialog is drawn: O opens it, the rest is typed.
  type(GLFW_KEY_O, GLFW_MOD_CONTROL);
  for (const int key : {GLFW_KEY_P, GLFW_KEY_0, GLFW_KEY_Z, GLFW_KEY_H, GLFW_KEY_2, GLFW_KEY_TAB})
    type(key, 0);
  input.key(GLFW_KEY_W, true, false, 0, false, actions);
  input.tick(actions);
  const std::string camera = format_camera(driven.viewer.camera);
  driven.apply_all(std::exchange(actions, {}));
  EXPECT_TRUE(driven.viewer.panels.open);
  EXPECT_TRUE(driven.viewer.panels.all);
  EXPECT_THAT(driven.jobs, IsEmpty());
  EXPECT_FALSE(driven.viewer.heatmap);
  EXPECT_EQ(driven.viewer.mode(), default_mode());
  EXPECT_EQ(format_camera(driven.viewer.camera), camera);
  driven.apply(toggle_panel, &Panels::open);
  type(GLFW_KEY_H, 0);
  driven.apply_all(actions);
  EXPECT_TRUE(driven.viewer.heatmap) << "keys act again once it is closed";
}

TEST(Input, held_keys_fly_until_they_are_released_or_the_focus_is_lost) {
  DrivenScene driven(1), expected(1);
  Input input;
  Actions actions;
  input.key(GLFW_KEY_W, true, false, 0, false, actions);
  input.key(GLFW_KEY_D, true, false, GLFW_MOD_SHIFT, false, actions);
  input.tick(actions);
  ASSERT_THAT(actions, SizeIs(1));
  driven.apply_all(actions);
  expected.apply(action::fly, glm::dvec3(1, 0, 1), 5.0);
  EXPECT_EQ(driven.viewer.flight.wish, glm::dvec3(2.5, 0, 5));
  EXPECT_EQ(driven.viewer.flight.wish, expected.viewer.flight.wish);
  actions.clear();
  input.release_all(actions);
  input.tick(actions);
  EXPECT_THAT(actions, IsEmpty());
  EXPECT_FALSE(input.busy());
}

TEST(Input, the_previous_mode_shows_while_its_key_is_held) {
  DrivenScene driven(1);
  driven.press("2");
  Input input;
  Actions actions;
  input.key(GLFW_KEY_GRAVE_ACCENT, true, false, 0, false, actions);
  input.key(GLFW_KEY_GRAVE_ACCENT, true, true, 0, false, actions);
  ASSERT_THAT(actions, SizeIs(1));
  driven.apply_all(std::exchange(actions, {}));
  EXPECT_EQ(driven.viewer.mode(), default_mode());
  input.release_all(actions);
  ASSERT_THAT(actions, SizeIs(1));
  driven.apply_all(actions);
  EXPECT_EQ(driven.viewer.mode(), 2);
}

TEST(Input, two_quick_clicks_in_place_pick_the_pivot) {
  DrivenScene driven(1);  // its inspector is closed: only a pick runs a job
  Input input;
  const auto click = [&](double now) {
    Actions actions;
    input.button(GLFW_MOUSE_BUTTON_LEFT, true, false, now, actions);
    input.button(GLFW_MOUSE_BUTTON_LEFT, false, false, now, actions);
    driven.apply_all(actions);
    return driven.jobs.size();
  };
  EXPECT_EQ(click(1), 0u);
  EXPECT_EQ(click(2), 0u);
  EXPECT_EQ(click(2.2), 1u);
  EXPECT_EQ(click(2.3), 1u);  // a third click does not pick again
}

TEST(Input, a_click_that_does_not_drag_inspects) {
  DrivenScene driven(1);
  driven.press("B");
  const auto click = [&](glm::dvec2 released_at) {
    Input input;
    Actions actions;
    input.cursor({40, 30}, Navigation::orbit, actions);
    input.button(GLFW_MOUSE_BUTTON_LEFT, true, false, 1, actions);
    input.cursor(released_at, Navigation::orbit, actions);
    driven.apply_all(std::exchange(actions, {}));
    input.button(GLFW_MOUSE_BUTTON_LEFT, false, false, 1, actions);
    driven.apply_all(actions);
    return driven.jobs.size();
  };
  EXPECT_EQ(click({60, 30}), 0u);
  EXPECT_EQ(click({40, 30}), 1u);
}

}  // namespace
}  // namespace qs
