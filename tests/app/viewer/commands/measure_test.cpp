// SPDX-License-Identifier: MIT
//
// Measuring without a window: clicks and the cross set points of surfaces, rulers are hidden behind
// surfaces, a known length and a ground change the numbers.
#include <filesystem>
#include <fstream>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/rendering_viewer.h"
#include "app/viewer/commands/controls.h"
#include "app/viewer/commands/input.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/panel_model/panel_model.h"
#include "app/viewer/state/edit_actions.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/kept_work.h"
#include "app/viewer/state/measure_actions.h"
#include "io/camera/lens_views.h"
#include "io/edits/edits_file.h"
#include "io/edits/measures_file.h"
#include "support/scene_files.h"

namespace qs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// Adds flat opaque Gaussians at this depth, with their centres x and y within the limits.
void add_wall(GaussianCloud& cloud, float z, float left, float right, float top, float bottom) {
  constexpr float kStep = 0.1f;
  for (float y = top; y <= bottom; y += kStep)
    for (float x = left; x <= right; x += kStep) {
      GaussianCloud flat = test::single_gaussian({x, y, z}, 0.06f, {0.5f, 0.5f, 0.5f}, 6);
      flat.log_scales[0].z = -INFINITY;
      test::append(cloud, flat);
    }
}

// The wall z = 4, and before it, in the middle, a board z = 2. The right end shows nothing.
class Measures : public test::RenderingViewer {
 protected:
  Measures() {
    Scene scene;
    add_wall(scene.cloud, 4, -2.6f, 1.6f, -2, 2);
    add_wall(scene.cloud, 2, -0.3f, 0.3f, -0.8f, 0.4f);
    scene.path = scenes_ / "walls.ply";
    test::write_scene(scene.cloud, scene.path);
    ViewedScene facts;
    facts.name = "walls";
    facts.path = scene.path;
    facts.core = {glm::vec3(-1), glm::vec3(1)};
    facts.gaussians = scene.cloud.size();
    show(std::move(scene), facts);
    apply(call(action::set_camera, test::front_camera(96, 64)));
    press("Shift+M");
  }
  void click(glm::dvec2 pixel) {
    Actions actions;
    input_.cursor(pixel, Navigation::orbit, actions);
    input_.button(GLFW_MOUSE_BUTTON_LEFT, true, false, 0, actions);
    input_.button(GLFW_MOUSE_BUTTON_LEFT, false, false, 0, actions);
    for (const Action& action : actions) apply(action);
    settle();
  }
  void open_other() {
    Scene scene;
    scene.cloud = test::random_cloud(20, 0, 7);
    scene.path = scenes_ / "other.ply";
    ViewedScene facts;
    facts.path = scene.path;
    show(std::move(scene), facts);
  }
  void use(const char* name, double value = 0) {
    const auto action = set_control(viewer(), *find_control(name), value, 0);
    ASSERT_TRUE(action) << name;
    apply(*action);
    settle();
  }
  // The place on the wall at this depth that a pixel shows.
  glm::dvec3 seen(glm::dvec2 pixel, double z) const {
    const Camera& camera = viewer().camera;
    return glm::dvec3((pixel - camera.center_px) / camera.focal_px, 1) * z;
  }
  const PointMeasures& measuring() { return viewer().measures; }
  // As a file has them: without the Gaussians.
  qs::Measures stored() {
    qs::Measures measures = measuring();
    for (auto& line : measures.lines)
      for (SurfacePoint& point : line) point.gaussian = 0;
    return measures;
  }
  std::string last_toast() { return viewer().toasts.back().text; }

  Input input_;
};

TEST_F(Measures, a_click_sets_a_point_on_the_first_surface) {
  EXPECT_TRUE(viewer().panels.measures);
  click({10, 20});
  click({48, 30});
  ASSERT_THAT(measuring().lines, SizeIs(1));
  ASSERT_THAT(measuring().lines[0], SizeIs(2));
  EXPECT_LT(glm::distance(measuring().lines[0][0].position, seen({10, 20}, 4)), 1e-5);
  EXPECT_LT(glm::distance(measuring().lines[0][1].position, seen({48, 30}, 2)), 1e-5);
  const double length = glm::distance(seen({10, 20}, 4), seen({48, 30}, 2));
  const auto rows = rows_of_measures(viewer());
  ASSERT_THAT(rows, SizeIs(3));
  EXPECT_EQ(rows[0].name, "point 1");
  EXPECT_EQ(rows[2].name, "1 to 2");
  EXPECT_THAT(rows[2].value, HasSubstr(fmt::format("{:.5g} ± ", length)));
  EXPECT_THAT(rows[2].value, HasSubstr(" units"));
  // Nothing is at the right end.
  click({95, 30});
  EXPECT_THAT(last_toast(), HasSubstr("no surface is here"));
  EXPECT_EQ(measuring().points(), 2u);
  // A drag turns the view and sets no point.
  const Camera before = viewer().camera;
  Actions actions;
  input_.button(GLFW_MOUSE_BUTTON_LEFT, true, false, 0, actions);
  input_.cursor({40, 20}, Navigation::orbit, actions);
  input_.button(GLFW_MOUSE_BUTTON_LEFT, false, false, 0, actions);
  for (const Action& action : actions) apply(action);
  settle();
  EXPECT_NE(viewer().camera.view_from_world, before.view_from_world);
  EXPECT_EQ(measuring().points(), 2u);
}

TEST_F(Measures, the_keyboard_alone_sets_points_and_ends_lines) {
  const auto enter = [&] {
    press("Enter");
    settle();
  };
  press("Right");
  EXPECT_EQ(viewer().cross, glm::dvec2(49, 32));
  enter();
  for (const char* key : {"Shift+Left", "Left", "Up", "Shift+Up", "Down", "Shift+Down"}) press(key);
  EXPECT_EQ(viewer().cross, glm::dvec2(38, 32));
  enter();
  enter();
  EXPECT_THAT(measuring().lines, SizeIs(2));
  press("Shift+Left");
  enter();
  EXPECT_THAT(measuring().lines[0], SizeIs(2));
  EXPECT_THAT(measuring().lines[1], SizeIs(1));
  EXPECT_LT(glm::distance(measuring().lines[0][1].position, seen({38, 32}, 2)), 1e-5);
  for (int i = 0; i < 20; ++i) press("Shift+Right");
  EXPECT_EQ(viewer().cross, glm::dvec2(95, 32)) << "inside of the picture";
  press("Escape");
  EXPECT_FALSE(measuring().picks);
  EXPECT_FALSE(viewer().cross);
  const auto before = viewer().camera.view_from_world;
  press("Left");
  EXPECT_FALSE(viewer().cross) << "there is no tool";
  EXPECT_NE(viewer().camera.view_from_world, before) << "the view turns";
  press("Right");
  EXPECT_EQ(measuring().points(), 3u) << "the points stay";
}

TEST_F(Measures, a_known_length_sets_the_scale_and_three_points_the_ground) {
  EXPECT_EQ(scale_preview(viewer()), "Set two points at a known distance.");
  EXPECT_FALSE(set_control(viewer(), *find_control("Set the scale"), 0, 0)) << "without points";
  click({10, 20});
  click({30, 20});
  use("known length", 5);
  use("unit", 1);
  const double length = glm::distance(seen({10, 20}, 4), seen({30, 20}, 4));
  EXPECT_THAT(scale_preview(viewer()), HasSubstr(fmt::format("1 unit = {:.5g} ± ", 5 / length)));
  EXPECT_TRUE(measuring().scale.unit.empty()) << "a preview";
  use("Set the scale");
  EXPECT_NEAR(measuring().scale.factor, 5 / length, 1e-4);
  EXPECT_THAT(rows_of_measures(viewer())[2].value, HasSubstr("5 ± "));
  EXPECT_THAT(rulers_of(viewer())[0].text, HasSubstr(" cm"));
  // Three points of the wall: up is the camera's side.
  EXPECT_FALSE(set_control(viewer(), *find_control("Set the ground"), 0, 0));
  click({20, 50});
  use("Set the ground");
  ASSERT_TRUE(measuring().ground);
  EXPECT_THAT(last_toast(), HasSubstr("the three points are level, ± "));
  EXPECT_EQ(measuring().ground->up, glm::dvec3(0, 0, -1));
  EXPECT_EQ(viewer().scene->up, glm::dvec3(0, 0, -1));
  click({48, 30});
  const auto rows = rows_of_measures(viewer());
  EXPECT_EQ(rows[3].name, "point 4");
  EXPECT_THAT(rows[3].more, HasSubstr(fmt::format("{:.5g} ± ", 2 * measuring().scale.factor)));
  EXPECT_THAT(rows[3].more, HasSubstr("cm above the ground"));
  EXPECT_EQ(viewer().scene->edits.steps, 0) << "the scene stays as it is";
  // The file of edits has both for convert.
  press("Ctrl+S");
  settle();
  const EditsFile file = read_edits(scenes_ / "walls_0001.edits.json", glm::dvec3(0));
  ASSERT_THAT(file.steps, SizeIs(2));
  EXPECT_EQ(file.steps[0].kind, EditKind::scale);
  EXPECT_EQ(file.steps[0].factor, measuring().scale.factor);
  EXPECT_EQ(file.steps[0].unit, "cm");
  EXPECT_EQ(file.steps[1].kind, EditKind::level);
  EXPECT_LT(glm::distance(file.steps[1].rotation * glm::dvec3(0, 0, -1), glm::dvec3(0, -1, 0)),
            1e-9);
}

TEST_F(Measures, points_on_a_line_are_no_ground) {
  for (const double x : {10, 20, 30}) click({x, 20});
  use("Set the ground");
  EXPECT_FALSE(measuring().ground);
  EXPECT_THAT(last_toast(), HasSubstr("on a line"));
}

TEST_F(Measures, rulers_are_hidden_behind_surfaces) {
  // From left to right on the wall, behind the board in the middle.
  click({10, 30});
  click({80, 30});
  const auto rest = [&] {
    change([](Viewer& v) {
      v.shown.version = v.version;
      v.shown.divisor = 1;
      v.now = v.last_motion + 10;
    });
    apply(call(action::follow_measures));
    for (Job& job : std::exchange(jobs_behind, {})) thread_.run(std::move(job));
    settle();
  };
  EXPECT_THAT(rulers_of(viewer())[0].hidden, IsEmpty());
  rest();
  const std::vector<bool> hidden = rulers_of(viewer())[0].hidden;
  ASSERT_THAT(hidden, SizeIs(kRulerParts));
  // The board covers the pixels whose rays meet it: |x| <= 0.3 at the depth 2.
  const Camera& camera = viewer().camera;
  for (std::size_t i = 0; i < kRulerParts; ++i) {
    const double x = 10 + 70 * (static_cast<double>(i) + 0.5) / kRulerParts;
    const double on_board = std::abs(x - camera.center_px.x) / camera.focal_px.x * 2;
    if (on_board < 0.25 || on_board > 0.5) {
      EXPECT_EQ(hidden[i], on_board < 0.25) << x;
    }
  }
  EXPECT_THAT(state_json(viewer()), HasSubstr("\"known\": true"));
  // Another view is not known until it rests.
  apply(call(action::orbit, glm::dvec2(10, 0)));
  EXPECT_THAT(rulers_of(viewer())[0].hidden, IsEmpty());
  rest();
  EXPECT_THAT(rulers_of(viewer())[0].hidden, SizeIs(kRulerParts));
  // Another point asks again.
  click({20, 50});
  EXPECT_THAT(rulers_of(viewer())[0].hidden, IsEmpty());
  rest();
  EXPECT_THAT(rulers_of(viewer()), SizeIs(2));
  EXPECT_THAT(rulers_of(viewer())[1].hidden, SizeIs(kRulerParts));
}

TEST_F(Measures, numbers_are_copied_and_points_taken_back) {
  press("Ctrl+M");
  EXPECT_THAT(last_toast(), HasSubstr("nothing to copy"));
  click({10, 20});
  click({30, 20});
  press("Ctrl+M");
  std::string table;
  for (const MeasureRow& row : rows_of_measures(viewer()))
    table += row.name + "\t" + row.value + "\t" + row.more + "\n";
  EXPECT_EQ(clipboard(), table);
  use("New line");
  click({30, 50});
  EXPECT_THAT(measuring().lines, SizeIs(2));
  for (const std::size_t left : {2u, 1u, 0u}) {
    use("Remove the last point");
    EXPECT_EQ(measuring().points(), left);
  }
  EXPECT_FALSE(set_control(viewer(), *find_control("Remove the last point"), 0, 0));
  click({10, 20});
  use("Clear");
  EXPECT_THAT(rows_of_measures(viewer()), IsEmpty());
}

TEST_F(Measures, stay_beside_the_scene_and_come_back_with_it) {
  const auto kept = scenes_ / "walls.ply.measures.json";
  const auto rest = [&] {
    apply(call(action::follow_measures));
    settle();
  };
  rest();
  EXPECT_FALSE(std::filesystem::exists(kept)) << "nothing is measured";
  click({10, 20});
  click({30, 20});
  use("unit", 1);
  use("Set the scale");
  click({20, 50});
  use("Set the ground");
  EXPECT_TRUE(measures_are_to_keep(viewer()));
  rest();
  EXPECT_FALSE(measures_are_to_keep(viewer()));
  const qs::Measures before = stored();
  EXPECT_EQ(read_measures(kept, glm::dvec3(0)).measures, before);
  // Another scene, and back.
  const ViewedScene walls = *viewer().scene;
  const auto open_walls = [&] {
    Scene scene = test::read_scene(walls.path);
    scene.path = walls.path;
    show(std::move(scene), walls);
    settle();
  };
  open_other();
  EXPECT_EQ(measuring().points(), 0u);
  open_walls();
  EXPECT_EQ(measuring().points(), 3u);
  EXPECT_EQ(measuring().lines[0], before.lines[0]);
  EXPECT_EQ(measuring().scale, before.scale);
  EXPECT_EQ(measuring().ground, before.ground);
  EXPECT_THAT(last_toast(), HasSubstr("walls.ply.measures.json: 3 measured points, 1 unit = "));
  EXPECT_FALSE(measures_are_to_keep(viewer()));
  // The file of another scene stays under another name.
  open_other();
  std::ofstream(kept) << R"({"version": 1, "scene": {"gaussians": 7}, "lines": []})";
  open_walls();
  EXPECT_THAT(last_toast(), HasSubstr("it is of a scene of 7 Gaussians, and walls.ply has"));
  EXPECT_EQ(measuring().points(), 0u);
  apply(call(action::pick_points, true));
  click({10, 20});
  rest();
  EXPECT_TRUE(std::filesystem::exists(scenes_ / "walls.ply_0001.measures.json"));
  EXPECT_EQ(read_measures(kept, glm::dvec3(0)).measures.points(), 1u);
  // Without measures there is no file.
  use("Clear");
  rest();
  EXPECT_FALSE(std::filesystem::exists(kept));
  // Without settings nothing is kept, and leaving asks.
  change([](Viewer& v) { v.keeps_work = false; });
  click({10, 20});
  rest();
  EXPECT_FALSE(std::filesystem::exists(kept));
  EXPECT_EQ(unsaved_text(viewer(), ""), "measures");
  apply(call(action::save_and_leave, std::filesystem::path()));
  settle();
  EXPECT_EQ(quits, 1);
  EXPECT_EQ(read_measures(scenes_ / "walls_0001.measures.json", glm::dvec3(0)).measures.points(),
            1u);
}

TEST_F(Measures, a_saved_file_is_opened_and_another_scene_s_is_refused) {
  click({10, 20});
  click({30, 20});
  click({20, 50});
  use("Set the ground");
  const qs::Measures before = stored();
  use("Save the measures");
  const auto file = scenes_ / "walls_0001.measures.json";
  EXPECT_THAT(last_toast(), HasSubstr("walls_0001.measures.json (3 points)"));
  use("Clear");
  change([](Viewer& v) {
    v.measures.ground.reset();
    v.scene->up = {0, -1, 0};
  });
  apply(call(action::open, file));
  settle();
  EXPECT_EQ(measuring().lines[0], before.lines[0]);
  EXPECT_EQ(viewer().scene->up, glm::dvec3(0, 0, -1));
  // The next point begins a line.
  click({10, 20});
  EXPECT_THAT(measuring().lines, SizeIs(2));
  std::ofstream(scenes_ / "walls.ply", std::ios::app) << "changed";
  apply(call(action::open, file));
  settle();
  EXPECT_THAT(last_toast(), HasSubstr("it is of a file with hash"));
  EXPECT_EQ(measuring().points(), 4u);
}

TEST_F(Measures, a_second_view_moves_the_last_point_to_where_both_sights_cross) {
  EXPECT_FALSE(set_control(viewer(), *find_control("Second view"), 1, 0)) << "without a point";
  click({10, 20});
  const glm::dvec3 place = measuring().lines[0][0].position;
  // Both views show a place before the wall, on the first line of sight.
  const glm::dvec3 meant = 0.75 * place;
  use("Second view", 1);
  click({10, 20});
  EXPECT_THAT(last_toast(), HasSubstr("parallel"));
  EXPECT_EQ(measuring().lines[0][0].position, place);
  use("Second view", 1);
  const Camera second = look_at({2, 0.5, 0}, meant, {0, -1, 0}, glm::radians(60.0), 96, 64);
  apply(call(action::set_camera, second));
  apply(call(action::measure_pixel, viewer().camera.center_px));
  ASSERT_THAT(measuring().lines[0], SizeIs(1));
  EXPECT_LT(glm::distance(measuring().lines[0][0].position, meant), 1e-6);
  EXPECT_THAT(last_toast(), HasSubstr("from two views: ± "));
  EXPECT_FALSE(measuring().again) << "once";
  EXPECT_TRUE(measuring().picks);
}

TEST_F(Measures, the_selection_has_dimensions_in_the_unit) {
  EXPECT_FALSE(set_control(viewer(), *find_control("Measure the selection"), 0, 0));
  press("Ctrl+A");
  apply(call(action::follow_edits));
  settle();
  use("Measure the selection");
  ASSERT_TRUE(measuring().box);
  EXPECT_NEAR(measuring().box->all.x, 4.2, 1e-4);
  EXPECT_NEAR(measuring().box->all.y, 3.9, 1e-4);
  EXPECT_NEAR(measuring().box->all.z, 2, 1e-4);
  EXPECT_LT(measuring().box->core.x, 4.1);
  EXPECT_GT(measuring().box->core.x, 3.5);
  EXPECT_EQ(measuring().box->gaussians, viewer().scene->gaussians);
  EXPECT_THAT(rows_of_measures(viewer()).back().value, HasSubstr("4.2 x 3.9 x 2 units"));
}

TEST_F(Measures, another_scene_has_no_points_of_the_last) {
  click({10, 20});
  apply(call(action::measure_pixel, glm::dvec2(12, 20)));
  open_other();
  EXPECT_EQ(measuring().points(), 0u);
  EXPECT_FALSE(measuring().picks);
}

TEST_F(Measures, a_lens_is_refused_and_a_tool_ends_the_other) {
  apply(call(action::change_settings, [&] {
    RenderSettings settings = viewer().settings;
    settings.lens = std::make_shared<const LensView>(fisheye_view(180));
    return settings;
  }()));
  click({10, 20});
  EXPECT_THAT(last_toast(), HasSubstr("pinhole"));
  press("Shift+B");
  EXPECT_FALSE(measuring().picks);
  apply(call(action::pick_points, true));
  EXPECT_FALSE(viewer().selecting.tool);
  press("Shift+M");
  EXPECT_FALSE(measuring().picks);
  EXPECT_FALSE(viewer().panels.measures);
}

}  // namespace
}  // namespace qs
