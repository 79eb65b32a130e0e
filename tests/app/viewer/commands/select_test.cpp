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
#include "app/viewer/commands/input.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/kept_work.h"
#include "app/viewer/state/select_actions.h"
#include "raster/scene/cloud_order.h"
#include "raster/select/by_shape.h"
#include "support/pool.h"

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
  EXPECT_THAT(jobs, SizeIs(1));
  EXPECT_TRUE(viewer.selecting.busy);
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
  for (const char* tool : {"rectangle", "lasso", "brush"}) {
    press("Shift+B");
    jobs.clear();
    button(GLFW_MOUSE_BUTTON_LEFT, true);
    button(GLFW_MOUSE_BUTTON_LEFT, false);
    EXPECT_THAT(jobs, SizeIs(tool == std::string("brush") ? 1 : 0)) << tool;
  }
  press(".");
  EXPECT_FLOAT_EQ(viewer.selecting.brush_px, 37.5f);
  press(",");
  EXPECT_FLOAT_EQ(viewer.selecting.brush_px, 30);
  EXPECT_THAT(shape_lines(viewer), SizeIs(32));
  press("Shift+B");
  EXPECT_FALSE(viewer.selecting.tool) << "after the last tool";
}

TEST_F(SelectDrags, a_cancelled_shape_selects_nothing) {
  press("Shift+B");
  button(GLFW_MOUSE_BUTTON_LEFT, true);
  cursor({150, 80});
  press("Escape");
  EXPECT_TRUE(viewer.selecting.tool);
  jobs.clear();
  button(GLFW_MOUSE_BUTTON_LEFT, false);
  EXPECT_THAT(jobs, IsEmpty());
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
    settle();
    follow();
  }
  void follow() {
    apply(call(action::follow_crop));
    settle();
  }
  GaussianSet seen(glm::dvec2 from, glm::dvec2 to, const GaussianCloud& cloud) {
    const auto renderer = make_renderer(Backend::cpu, test::pool());
    renderer->upload(GaussianCloud(cloud), {});
    return seen_in_whole(*renderer, cloud, viewer().camera, Shape::rectangle(from, to),
                         kSelectWeight, test::pool(), {});
  }
  const GaussianSet& selected() { return *viewer().crop.wish.selected; }

  const GaussianCloud cloud_ = test::random_cloud(300, 1, 5);
  const glm::dvec2 a_{20, 10}, b_{60, 50}, c_{80, 60};
};

TEST_F(SelectJobs, a_rectangle_selects_the_visible_gaussians_which_are_tinted_and_counted) {
  drag(a_, b_);
  ASSERT_TRUE(viewer().crop.wish.selected);
  EXPECT_EQ(selected(), seen(a_, b_, cloud_));
  EXPECT_EQ(wanted_crop(viewer()).view, CropView::marked);
  EXPECT_EQ(crop_text(viewer()),
            fmt::format("{0} of 300 Gaussians would go: {0} selected", selected().count()));
  // Modifiers combine with the selection before.
  GaussianSet all = selected();
  drag(b_, c_, SelectHow::add);
  EXPECT_EQ(selected(), all |= seen(b_, c_, cloud_));
  drag(a_, b_, SelectHow::take_away);
  EXPECT_EQ(selected(), all -= seen(a_, b_, cloud_));
}

TEST_F(SelectJobs, removed_gaussians_are_gone_and_come_back_selected) {
  drag(a_, b_);
  const GaussianSet first = selected();
  press("Delete");
  follow();
  EXPECT_EQ(viewer().scene->gaussians, 300 - first.count());
  EXPECT_EQ(viewer().scene->edits.kept, 300 - first.count());
  // A second selection is of the rest.
  const GaussianCloud rest = select(cloud_, first.complement().numbers());
  drag(a_, b_);
  EXPECT_EQ(selected(), seen(a_, b_, rest));
  press("Delete");
  follow();
  EXPECT_EQ(viewer().scene->gaussians, rest.size() - seen(a_, b_, rest).count());
  press("Shift+R");
  follow();
  EXPECT_EQ(viewer().scene->gaussians, rest.size());
  press("Shift+R");
  follow();
  EXPECT_EQ(viewer().scene->gaussians, 300u);
  EXPECT_EQ(selected(), first);
}

TEST_F(SelectJobs, keys_select_all_nothing_and_the_others) {
  drag(a_, b_);
  const GaussianSet first = selected();
  const auto press_and_follow = [&](const char* key) {
    press(key);
    settle();
    follow();
  };
  press_and_follow("Ctrl+I");
  EXPECT_EQ(selected(), first.complement());
  press_and_follow("Ctrl+A");
  EXPECT_EQ(selected().count(), 300u);
  press("Delete");
  follow();
  EXPECT_EQ(viewer().scene->gaussians, 300u);
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("300 of 300 Gaussians would go"));
  press_and_follow("Ctrl+Shift+A");
  EXPECT_FALSE(viewer().crop.wish.selected);
}

TEST_F(SelectJobs, saved_edits_are_carried_out_by_the_program_to_the_same_gaussians) {
  EXPECT_EQ(unsaved_text(viewer(), {}), "");
  drag(a_, b_);
  press("Delete");
  follow();
  drag(b_, c_);
  press("Delete");
  follow();
  drag(a_, c_);
  EXPECT_THAT(unsaved_text(viewer(), {}), HasSubstr("Ctrl+S saves them"));
  press("Ctrl+S");
  settle();
  EXPECT_EQ(unsaved_text(viewer(), {}), "");
  Scene scene = test::read_scene(viewer().scene->path);
  const EditOptions options{viewer().out_dir / "random_0001.edits.json"};
  const EditedCloud all = edited(scene, options, test::pool());
  EXPECT_EQ(all.state.rest().count(), viewer().scene->gaussians);
  EXPECT_EQ(all.state.selected.count(), selected().count());
  std::vector<std::uint32_t> numbers = all.state.rest().numbers(), expected;
  selected().for_each([&](std::size_t i) { expected.push_back(numbers[i]); });
  EXPECT_EQ(all.state.selected.numbers(), expected);
}

TEST_F(SelectJobs, without_an_edit_nothing_is_saved) {
  press("Ctrl+S");
  settle();
  EXPECT_EQ(viewer().toasts.back().text, "there is no edit to save");
}

}  // namespace
}  // namespace qs
