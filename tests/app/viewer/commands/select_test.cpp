// SPDX-License-Identifier: MIT
//
// Selecting in the picture without a window: drags, modifiers, removing, undoing and saving.
#include <fstream>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/session/scene_edits.h"
#include "app/support/driven_viewer.h"
#include "app/support/rendering_viewer.h"
#include "app/support/run_program.h"
#include "app/viewer/commands/controls.h"
#include "app/viewer/commands/input.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/edit_actions.h"
#include "app/viewer/state/kept_work.h"
#include "app/viewer/state/select_actions.h"
#include "base/path_kind.h"
#include "io/bytes/replace_file.h"
#include "raster/scene/cloud_order.h"
#include "raster/select/by_shape.h"
#include "support/pool.h"
#include "support/scene_files.h"

namespace qs {
namespace {

using test::DrivenScene;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// ---- drags -------------------------------------------------------------------------------------
class SelectDrags : public DrivenScene, public testing::Test {
 protected:
  SelectDrags() : DrivenScene(1) {}
  void cursor(glm::dvec2 pixel) {
    Actions actions;
    input_.cursor(pixel, Navigation::orbit, actions);
    apply_all(actions);
  }
  void button(int button, bool down) {
    Actions actions;
    input_.button(button, down, false, 0, actions);
    apply_all(actions);
  }
  void key(int key, bool down) {
    Actions actions;
    input_.key(key, down, false, 0, false, actions);
    apply_all(actions);
  }
  Input input_;
};

TEST_F(SelectDrags, draw_with_a_tool_and_move_the_view_without_one) {
  const Camera before = viewer.camera;
  press("Shift+B");
  EXPECT_EQ(viewer.selecting.tool, SelectTool::rectangle);
  EXPECT_TRUE(viewer.panels.crop);
  cursor({100, 50});
  button(GLFW_MOUSE_BUTTON_LEFT, true);
  cursor({150, 80});
  cursor({200, 90});
  EXPECT_THAT(viewer.selecting.drawn, SizeIs(2));
  EXPECT_THAT(shape_lines(viewer), SizeIs(4));
  EXPECT_EQ(viewer.camera.view_from_world, before.view_from_world);
  EXPECT_EQ(drawn_step(viewer).pixels, (std::vector<glm::dvec2>{{100, 50}, {200, 90}}));
  jobs.clear();
  button(GLFW_MOUSE_BUTTON_LEFT, false);
  EXPECT_THAT(viewer.editing.waiting, SizeIs(1));
  apply(action::follow_edits);
  EXPECT_THAT(jobs, SizeIs(1));
  EXPECT_TRUE(viewer.editing.busy);
  EXPECT_THAT(viewer.selecting.drawn, IsEmpty());
  // The right button turns the view.
  button(GLFW_MOUSE_BUTTON_RIGHT, true);
  cursor({260, 90});
  button(GLFW_MOUSE_BUTTON_RIGHT, false);
  const Camera turned = viewer.camera;
  EXPECT_NE(turned.view_from_world, before.view_from_world);
  // Escape ends the tool.
  press("Escape");
  EXPECT_FALSE(viewer.selecting.tool);
  button(GLFW_MOUSE_BUTTON_LEFT, true);
  cursor({300, 90});
  button(GLFW_MOUSE_BUTTON_LEFT, false);
  EXPECT_NE(viewer.camera.view_from_world, turned.view_from_world);
  EXPECT_THAT(jobs, SizeIs(1));
}

TEST_F(SelectDrags, combine_by_the_modifiers_that_are_held) {
  press("Shift+B");
  const std::pair<std::vector<int>, SelectHow> kHow[] = {
      {{}, SelectHow::replace},
      {{GLFW_KEY_LEFT_SHIFT}, SelectHow::add},
      {{GLFW_KEY_RIGHT_CONTROL}, SelectHow::take_away},
      {{GLFW_KEY_LEFT_CONTROL, GLFW_KEY_LEFT_SHIFT}, SelectHow::common}};
  for (const auto& [keys, how] : kHow) {
    for (const int each : keys) key(each, true);
    button(GLFW_MOUSE_BUTTON_LEFT, true);
    for (const int each : keys) key(each, false);
    EXPECT_EQ(viewer.selecting.how, how);
    button(GLFW_MOUSE_BUTTON_LEFT, false);
  }
}

TEST_F(SelectDrags, a_click_selects_with_the_brush_only) {
  for (const char* tool : {"rectangle", "polygon", "lasso", "brush"}) {
    press("Shift+B");
    button(GLFW_MOUSE_BUTTON_LEFT, true);
    button(GLFW_MOUSE_BUTTON_LEFT, false);
    EXPECT_THAT(viewer.editing.waiting, SizeIs(tool == std::string("brush") ? 1 : 0)) << tool;
    EXPECT_THAT(viewer.selecting.drawn, SizeIs(tool == std::string("polygon") ? 1 : 0)) << tool;
  }
  press(".");
  EXPECT_FLOAT_EQ(viewer.selecting.brush_px, 37.5f);
  press(",");
  EXPECT_FLOAT_EQ(viewer.selecting.brush_px, 30);
  EXPECT_THAT(shape_lines(viewer), SizeIs(32));
  for (int more = 0; more < 3; ++more) press("Shift+B");
  EXPECT_FALSE(viewer.selecting.tool) << "after the last tool";
}

TEST_F(SelectDrags, a_cancelled_shape_selects_nothing) {
  press("Shift+B");
  button(GLFW_MOUSE_BUTTON_LEFT, true);
  cursor({150, 80});
  press("Escape");
  EXPECT_TRUE(viewer.selecting.tool);
  button(GLFW_MOUSE_BUTTON_LEFT, false);
  EXPECT_THAT(viewer.editing.waiting, IsEmpty());
}

// ---- the scene that the render thread shows -----------------------------------------------------
class SelectJobs : public test::RenderingViewer {
 protected:
  SelectJobs() {
    change([](Viewer& v) { v.scene->gaussians = 300; });
    press("Shift+B");
  }
  void drag(glm::dvec2 from, glm::dvec2 to, SelectHow how = SelectHow::replace) {
    apply(call(action::begin_shape, from, how));
    apply(call(action::extend_shape, to));
    apply(call(action::end_shape));
    follow();
  }
  // Until every step is done and shown.
  void follow() {
    do {
      apply(call(action::follow_edits));
      settle();
    } while (viewer().editing.busy || !viewer().editing.waiting.empty() ||
             viewer().crop.asked != wanted_crop(viewer()));
  }
  void use(const char* key) {
    press(key);
    follow();
  }
  // By the numbers in the whole scene.
  GaussianSet seen(glm::dvec2 from, glm::dvec2 to, const GaussianSet& rest) {
    const auto renderer = make_renderer(Backend::cpu, test::pool());
    const std::vector<std::uint32_t> numbers = rest.numbers();
    const GaussianCloud cloud = select(cloud_, numbers);
    renderer->upload(GaussianCloud(cloud), {});
    GaussianSet all(300);
    seen_by(*renderer, cloud, viewer().camera, Shape::rectangle(from, to), kSelectWeight,
            test::pool(), {})
        .for_each([&](std::size_t i) { all.add(numbers[i]); });
    return all;
  }
  const EditState& state() { return viewer().editing.history.state(); }
  const GaussianSet& selected() { return state().selected; }
  std::string last_toast() { return viewer().toasts.back().text; }
  std::vector<std::uint8_t> picture() { return draw(full_frame(viewer()))->rgba; }

  const GaussianCloud cloud_ = test::random_cloud(300, 1, 5);
  const GaussianSet all_ = GaussianSet(300).complement();
  const glm::dvec2 a_{20, 10}, b_{60, 50}, c_{80, 60};
};

TEST_F(SelectJobs, a_rectangle_selects_the_visible_gaussians_which_are_tinted_and_counted) {
  drag(a_, b_);
  EXPECT_EQ(selected(), seen(a_, b_, all_));
  EXPECT_GT(selected().count(), 10u);
  ASSERT_TRUE(viewer().crop.tint);
  EXPECT_EQ(*viewer().crop.tint, selected());
  EXPECT_EQ(crop_text(viewer()),
            fmt::format("{0} of 300 Gaussians would go: {0} selected", selected().count()));
  // Modifiers combine with the selection before.
  GaussianSet all = selected();
  drag(b_, c_, SelectHow::add);
  EXPECT_EQ(selected(), all |= seen(b_, c_, all_));
  drag(a_, b_, SelectHow::take_away);
  EXPECT_EQ(selected(), all -= seen(a_, b_, all_));
}

TEST_F(SelectJobs, removed_gaussians_are_gone_and_come_back_selected) {
  const auto whole = picture();
  drag(a_, b_);
  const GaussianSet first = selected();
  use("Delete");
  EXPECT_EQ(viewer().scene->gaussians, 300 - first.count());
  EXPECT_EQ(viewer().scene->edits.kept, 300 - first.count());
  EXPECT_EQ(viewer().scene->edits.steps, 1);
  EXPECT_TRUE(selected().empty());
  // A second selection is of the rest.
  const GaussianSet rest = first.complement(), second = seen(a_, b_, rest);
  drag(a_, b_);
  EXPECT_EQ(selected(), second);
  use("Delete");
  EXPECT_EQ(viewer().scene->gaussians, rest.count() - second.count());
  EXPECT_EQ(viewer().scene->edits.steps, 2);
  const auto removed = picture();
  for (const std::size_t left : {rest.count(), rest.count(), std::size_t{300}, std::size_t{300}}) {
    use("Ctrl+Z");
    EXPECT_EQ(viewer().scene->gaussians, left);
  }
  EXPECT_EQ(picture(), whole);
  EXPECT_TRUE(selected().empty());
  use("Ctrl+Shift+Z");
  EXPECT_EQ(selected(), first);
  for (int step = 0; step < 3; ++step) use("Ctrl+Shift+Z");
  EXPECT_EQ(picture(), removed);
  EXPECT_FALSE(viewer().editing.history.can_redo());
}

TEST_F(SelectJobs, hidden_gaussians_are_shown_again) {
  const auto whole = picture();
  drag(a_, b_);
  const GaussianSet first = selected();
  use("Ctrl+H");
  EXPECT_EQ(state().hidden, first);
  EXPECT_EQ(viewer().scene->gaussians, 300 - first.count());
  EXPECT_EQ(crop_text(viewer()), fmt::format("{} of 300 Gaussians are left: {} hidden",
                                             300 - first.count(), first.count()));
  use("Ctrl+A");
  EXPECT_EQ(selected(), first.complement()) << "hidden Gaussians are never selected";
  use("Ctrl+Shift+A");
  use("Ctrl+Shift+H");
  EXPECT_TRUE(state().hidden.empty());
  EXPECT_EQ(viewer().scene->gaussians, 300u);
  EXPECT_EQ(viewer().scene->edits.steps, 0) << "the scene is as it was read";
  EXPECT_EQ(picture(), whole);
  use("Ctrl+Z");
  EXPECT_EQ(state().hidden, first);
}

TEST_F(SelectJobs, keys_select_all_nothing_and_the_others) {
  drag(a_, b_);
  const GaussianSet first = selected();
  use("Ctrl+I");
  EXPECT_EQ(selected(), first.complement());
  use("Ctrl+A");
  EXPECT_EQ(selected().count(), 300u);
  use("Delete");
  EXPECT_EQ(viewer().scene->gaussians, 300u);
  EXPECT_THAT(last_toast(), HasSubstr("300 of 300 Gaussians removed: the scene would be empty"));
  EXPECT_EQ(selected().count(), 300u);
  use("Ctrl+Shift+A");
  EXPECT_TRUE(selected().empty());
  use("Delete");
  EXPECT_THAT(last_toast(), HasSubstr("select Gaussians first"));
  drag(a_, b_);
  use("Shift+Delete");
  EXPECT_EQ(state().removed, first.complement());
  EXPECT_TRUE(selected().empty());
  use("Ctrl+Z");
  EXPECT_TRUE(state().removed.empty()) << "one step";
  EXPECT_EQ(selected(), first);
}

TEST_F(SelectJobs, keys_that_come_at_once_act_one_after_the_other) {
  apply(call(action::begin_shape, a_, SelectHow::replace));
  apply(call(action::extend_shape, b_));
  apply(call(action::end_shape));
  for (const char* key : {"Ctrl+I", "Delete", "Ctrl+A", "Ctrl+H"}) press(key);
  EXPECT_THAT(viewer().editing.waiting, SizeIs(5));
  follow();
  EXPECT_EQ(state().removed, seen(a_, b_, all_).complement());
  EXPECT_TRUE(state().hidden.empty()) << "nothing would be left";
  EXPECT_THAT(last_toast(), HasSubstr("would be empty"));
}

TEST_F(SelectJobs, a_step_ends_the_steps_that_were_taken_back) {
  drag(a_, b_);
  use("Ctrl+I");
  use("Ctrl+Z");
  EXPECT_TRUE(viewer().editing.history.can_redo());
  drag(b_, c_);
  EXPECT_FALSE(viewer().editing.history.can_redo());
  EXPECT_THAT(steps_of(viewer()), SizeIs(2));
}

TEST_F(SelectJobs, undo_is_of_the_edits_or_the_keyframes_by_their_last_change) {
  const auto at = [&](double now) { change([&](Viewer& v) { v.now = now; }); };
  at(1);
  press("K");
  at(2);
  drag(a_, b_);
  use("Ctrl+Z");
  EXPECT_TRUE(selected().empty());
  EXPECT_THAT(viewer().keyframes, SizeIs(1));
  use("Ctrl+Z");
  EXPECT_THAT(viewer().keyframes, IsEmpty());
  use("Ctrl+Z");
  EXPECT_EQ(last_toast(), "no change of the keyframes is left");
}

TEST_F(SelectJobs, saved_edits_are_carried_out_by_the_program_to_the_same_gaussians) {
  drag(a_, b_);
  use("Delete");
  drag(b_, c_);
  use("Ctrl+H");
  drag(a_, c_);
  press("Ctrl+S");
  settle();
  Scene scene = test::read_scene(viewer().scene->path);
  const EditOptions options{viewer().out_dir / "random_0001.edits.json"};
  const EditedCloud all = edited(scene, options, test::pool());
  EXPECT_EQ(all.state, state());
  ASSERT_THAT(all.file.steps, SizeIs(5));
  EXPECT_EQ(all.file.steps[0].select.tool, SelectTool::rectangle);
  EXPECT_EQ(all.file.steps[0].select.pixels, (std::vector<glm::dvec2>{a_, b_}));
  EXPECT_EQ(all.file.steps[1].kind, EditKind::remove);
  // The tools alone lead to the same Gaussians.
  EditOptions again = options;
  again.recomputes = true;
  EXPECT_EQ(edited(scene, again, test::pool()).state, state());
}

// ---- the file beside the scene ------------------------------------------------------------------
class KeptEdits : public SelectJobs {
 protected:
  KeptEdits() {
    change([](Viewer& v) { v.keeps_work = true; });
  }
  std::filesystem::path file() { return kept_edits_file(viewer().scene->path); }
  // As SelectJobs::follow(), and the file.
  void keep() {
    follow();
    apply(call(action::follow_edits));
    settle();
  }
  // The scene as it is read again.
  void reopen() {
    Scene scene = test::read_scene(viewer().scene->path);
    ViewedScene facts = *viewer().scene;
    facts.edits = {};
    facts.gaussians = scene.cloud.size();
    show(std::move(scene), facts);
    apply(call(action::choose_tool, SelectTool::rectangle));
    follow();
  }
};

TEST_F(KeptEdits, are_written_after_each_step_and_offered_when_the_scene_is_opened) {
  EXPECT_FALSE(is_there(file()));
  drag(a_, b_);
  keep();
  ASSERT_TRUE(is_there(file()));
  use("Delete");
  drag(b_, c_);
  use("Ctrl+Z");
  keep();
  const EditState before = state();
  const auto shown = picture();
  reopen();
  EXPECT_EQ(viewer().scene->gaussians, 300u);
  const auto offer = std::ranges::find(viewer().toasts, ToastOffer::apply_edits, &Toast::offer);
  ASSERT_NE(offer, viewer().toasts.end());
  EXPECT_THAT(offer->text, HasSubstr(" has edits of this scene"));
  apply(call(action::open, file()));
  follow();
  EXPECT_EQ(state(), before);
  EXPECT_THAT(steps_of(viewer()), SizeIs(2));
  EXPECT_EQ(picture(), shown);
  EXPECT_TRUE(viewer().editing.history.can_undo());
  // Further steps are written to the same file, and none leave no file.
  use("Ctrl+Z");
  use("Ctrl+Z");
  keep();
  EXPECT_FALSE(is_there(file()));
}

TEST_F(KeptEdits, of_large_selections_are_written_at_rest_and_before_the_window_closes) {
  drag(a_, b_);
  // A list of 2 MB, as in a scene of many millions.
  change([](Viewer& v) {
    EditStep step;
    step.select.tool = SelectTool::brush;
    step.select.camera = v.camera;
    step.select.members.emplace();
    for (std::uint64_t i = 0; i < 131'072; ++i) step.select.members->push_back({2 * i, 1});
    v.editing.history.take(step, v.editing.history.state());
    v.editing.kept = false;
    v.now = v.editing.changed = 100;
  });
  apply(call(action::follow_edits));
  EXPECT_FALSE(viewer().editing.kept) << "the next stroke may follow at once";
  change([](Viewer& v) { v.now = 100.9; });
  apply(call(action::follow_edits));
  EXPECT_FALSE(viewer().editing.kept);
  change([](Viewer& v) { v.now = 101.1; });
  apply(call(action::follow_edits));
  EXPECT_TRUE(viewer().editing.kept);
  settle();
  EXPECT_TRUE(is_there(file()));
  // A window that closes before has written it.
  std::filesystem::remove(file());
  change([](Viewer& v) {
    v.editing.kept = false;
    v.editing.changed = v.now;
  });
  apply(call(action::leave, std::filesystem::path()));
  EXPECT_EQ(quits, 0);
  settle();
  EXPECT_TRUE(is_there(file()));
  EXPECT_EQ(quits, 1);
}

TEST_F(KeptEdits, a_file_that_was_not_applied_is_set_aside) {
  write_text(file(), "{\"version\": 1, \"steps\": []}");
  reopen();
  drag(a_, b_);
  keep();
  std::filesystem::path aside = viewer().scene->path;
  aside += "_0001.edits.json";
  EXPECT_EQ(test::content_of(aside), "{\"version\": 1, \"steps\": []}");
  EXPECT_THAT(test::content_of(file()), HasSubstr("rectangle"));
}

TEST_F(KeptEdits, that_cannot_be_written_get_one_message_and_a_question_at_the_end) {
  std::filesystem::create_directories(file() / "folder");
  change([](Viewer& v) { v.editing.owns_file = true; });
  drag(a_, b_);
  keep();
  EXPECT_THAT(last_toast(), HasSubstr("the edits cannot be kept"));
  const std::size_t messages = viewer().log.size();
  use("Delete");
  keep();
  EXPECT_EQ(viewer().log.size(), messages + 1) << last_toast();
  EXPECT_EQ(unsaved_text(viewer(), {}), "edits (Ctrl+S saves them)");
  press("Ctrl+S");
  settle();
  EXPECT_EQ(unsaved_text(viewer(), {}), "");
}

TEST_F(KeptEdits, of_another_scene_or_damaged_are_refused_and_change_nothing) {
  drag(a_, b_);
  const EditState before = state();
  const std::pair<const char*, const char*> wrong[] = {
      {"{\"version\": 1, \"scene\": {\"gaussians\": 7}, \"steps\": []}", "7 Gaussians"},
      {"{\"version\": 3, \"steps\": []}", "version"},
      {"{\"version\": 1, \"steps\": [", "JSON"},
      {"{\"version\": 1, \"steps\": [{\"step\": \"remove\", \"x\": 1}, {\"step\": \"what\"}]}",
       "what"},
      {"{\"version\": 1, \"steps\": [{\"step\": \"select\", \"tool\": \"all\"}, "
       "{\"step\": \"remove\"}]}",
       "no Gaussian would be left"}};
  for (const auto& [content, problem] : wrong) {
    const std::filesystem::path path = scenes_ / "other.edits.json";
    write_text(path, content);
    apply(call(action::open, path));
    follow();
    EXPECT_TRUE(viewer().toasts.back().error) << content;
    EXPECT_THAT(last_toast(), HasSubstr(problem));
    EXPECT_EQ(state(), before);
  }
}

TEST_F(KeptEdits, are_not_written_for_pages_or_without_settings) {
  change([](Viewer& v) { v.keeps_work = false; });
  drag(a_, b_);
  keep();
  EXPECT_FALSE(is_there(file()));
  change([](Viewer& v) { v.keeps_work = v.is_remote = true; });
  drag(b_, c_);
  keep();
  EXPECT_FALSE(is_there(file()));
}

TEST_F(KeptEdits, of_a_part_of_the_file_are_of_the_whole_file) {
  const std::filesystem::path path = viewer().scene->path;
  Scene part = test::read_scene(path);
  const auto goes = [](std::size_t i) { return i % 3 == 0; };
  part.edits.remove(300, goes);
  std::vector<std::uint32_t> left;
  for (std::uint32_t i = 0; i < 300; ++i)
    if (!goes(i)) left.push_back(i);
  part.cloud = select(cloud_, left);
  ViewedScene facts = *viewer().scene;
  facts.gaussians = left.size();
  facts.edits = part.edits;
  show(std::move(part), facts);
  follow();
  apply(call(action::choose_tool, SelectTool::rectangle));
  drag(a_, b_);
  use("Delete");
  drag(b_, c_);
  press("Ctrl+S");
  settle();
  const EditedCloud all =
      edited(test::read_scene(path), {scenes_ / "random_0001.edits.json"}, test::pool());
  GaussianSet removed(300), selected(300);
  for (std::uint32_t i = 0; i < 300; i += 3) removed.add(i);
  state().removed.for_each([&](std::size_t i) { removed.add(left[i]); });
  selected = GaussianSet(300);
  state().selected.for_each([&](std::size_t i) { selected.add(left[i]); });
  EXPECT_GT(state().removed.count(), 0u);
  EXPECT_EQ(all.state.removed, removed);
  EXPECT_EQ(all.state.selected, selected);
}

// ---- other tools --------------------------------------------------------------------------------
TEST_F(SelectJobs, clicks_set_the_corners_of_a_polygon_and_enter_or_the_first_one_closes_it) {
  apply(call(action::choose_tool, SelectTool::polygon));
  const auto click = [&](glm::dvec2 pixel) {
    apply(call(action::begin_shape, pixel, SelectHow::replace));
    apply(call(action::end_shape));
  };
  const std::vector<glm::dvec2> corners = {{20, 10}, {70, 12}, {60, 50}, {25, 45}};
  for (const bool enter : {true, false}) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      click(corners[i]);
      if (i == 1) press("Enter");
    }
    EXPECT_THAT(viewer().selecting.drawn, SizeIs(4)) << "two points close nothing";
    EXPECT_THAT(shape_lines(viewer()), SizeIs(4));
    enter ? press("Enter") : click({22, 13});
    follow();
    EXPECT_EQ(steps_of(viewer()).back().select.pixels, corners);
    EXPECT_THAT(viewer().selecting.drawn, IsEmpty());
  }
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(GaussianCloud(cloud_), {});
  EXPECT_EQ(selected(), seen_by(*renderer, cloud_, viewer().camera, Shape::polygon(corners),
                                kSelectWeight, test::pool(), {}));
}

TEST_F(SelectJobs, a_sphere_is_around_the_surface_at_its_first_pixel) {
  apply(call(action::choose_tool, SelectTool::sphere));
  drag({48, 30}, {90, 30});
  const Outputs outputs{.color = false, .trace = true};
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(GaussianCloud(cloud_), {});
  const Camera& camera = viewer().camera;
  const auto point = surface_at(renderer->render(camera, {}, outputs), cloud_, camera, {48, 30});
  if (!point) {
    EXPECT_THAT(last_toast(), HasSubstr("no surface is here"));
    return;
  }
  ASSERT_THAT(steps_of(viewer()), SizeIs(1)) << last_toast();
  const double radius = 42 / camera.focal_px.x * point->position.z;
  EXPECT_NEAR(steps_of(viewer()).back().select.radius, radius, 1e-9);
  EXPECT_EQ(selected(),
            gaussians_at_distance(cloud_, point->position, {}, {0, radius}, test::pool()));
}

TEST_F(SelectJobs, a_colour_is_taken_from_the_pixel_also_while_it_is_tinted) {
  apply(call(action::choose_tool, SelectTool::color));
  change([](Viewer& v) { v.selecting.tolerance = 20; });
  const auto click = [&] {
    apply(call(action::begin_shape, glm::dvec2(48, 30), SelectHow::replace));
    apply(call(action::end_shape));
    follow();
    return GaussianSet(selected());
  };
  const GaussianSet first = click();
  ASSERT_FALSE(first.empty()) << last_toast();
  const glm::dvec3 color = steps_of(viewer()).back().select.color;
  EXPECT_EQ(first, gaussians_of_color(cloud_, color, 20, test::pool()));
  EXPECT_TRUE(viewer().crop.tint);
  EXPECT_EQ(click(), first);
}

TEST_F(SelectJobs, values_select_between_their_limits) {
  const auto set = [&](const char* control, double value = 0) {
    const auto action = set_control(viewer(), *find_control(control), value, 0);
    ASSERT_TRUE(action) << control;
    apply(*action);
    follow();
  };
  set("by opacity, from", 0.25);
  set("by opacity, to", 0.75);
  set("Select by opacity");
  EXPECT_EQ(selected(), gaussians_of_opacity(cloud_, {0.25, 0.75}, test::pool()));
  EXPECT_GT(selected().count(), 0u);
  set("by size, to", 0.1);
  set("Select by size");
  EXPECT_EQ(selected(), gaussians_of_size(cloud_, {0, 0.1}, test::pool()));
  set("Select by distance");
  EXPECT_THAT(last_toast(), HasSubstr("measure a point first"));
  SurfacePoint point;
  point.position = {0.5, 0, 5};
  change([&](Viewer& v) { v.measures.lines = {{point}, {}}; });
  set("by distance, to", 2);
  set("how", 1);
  set("Select by size");
  set("Select by distance");
  GaussianSet both = gaussians_of_size(cloud_, {0, 0.1}, test::pool());
  both |= gaussians_at_distance(cloud_, {0.5, 0, 5}, {}, {0, 2}, test::pool());
  EXPECT_EQ(selected(), both);
}

TEST_F(SelectJobs, the_keyboard_alone_draws_with_each_tool) {
  const auto move_to = [&](glm::dvec2 pixel) {
    change([&](Viewer& v) { v.cross = pixel, v.cross_is_used = false; });
  };
  struct Case {
    SelectTool tool;
    std::vector<glm::dvec2> places;
    bool closes;  ///< by a second Enter
  };
  const Case cases[] = {{SelectTool::rectangle, {a_, b_}, false},
                        {SelectTool::polygon, {{20, 10}, {60, 10}, {60, 50}}, true},
                        {SelectTool::lasso, {{30, 5}, {90, 10}, {70, 60}}, true},
                        {SelectTool::brush, {{20, 10}, {60, 10}}, true}};
  for (const Case& each : cases) {
    apply(call(action::choose_tool, each.tool));
    const std::size_t before = steps_of(viewer()).size();
    for (const glm::dvec2 place : each.places) {
      move_to(place);
      press("Enter");
    }
    if (each.closes) press("Enter");
    follow();
    ASSERT_THAT(steps_of(viewer()), SizeIs(before + 1)) << static_cast<int>(each.tool);
    EXPECT_EQ(steps_of(viewer()).back().select.tool, each.tool);
    EXPECT_EQ(steps_of(viewer()).back().select.pixels, each.places);
  }
}

TEST_F(SelectJobs, without_an_edit_nothing_is_saved) {
  press("Ctrl+S");
  settle();
  EXPECT_EQ(last_toast(), "there is no edit to save");
}

}  // namespace
}  // namespace qs
