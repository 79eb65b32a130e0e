// SPDX-License-Identifier: MIT
//
// Visitors of a scene with levels of detail: each view has its own cut, and they share the pages.
#include <atomic>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/serve/served_room.h"
#include "app/serve/state_json.h"
#include "app/viewer/state/edit_actions.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

using test::ServedRoom;
using testing::HasSubstr;

constexpr unsigned kBudget = 100;

// True if the visitor sees the cut of its own view.
bool has_its_cut(ServedRoom& room, int number) {
  const Viewer& v = room.viewer(number);
  return v.levels && v.levels->missing == 0 && v.shown.version == v.version && v.frames > 0 &&
         v.levels->camera.view_from_world == v.camera.view_from_world &&
         v.shown.stats.gaussians == v.levels->drawn;
}

void move(ServedRoom& room, int number, double distance, std::size_t scene = 0) {
  const Camera camera = look_at({0, 0, -distance}, {0, 0, 0}, {0, -1, 0}, 0.9, 64, 48);
  room.take(message::ShowView{scene, format_camera(camera), mode_name(default_mode())}, number);
}

// The pictures that visitors get in some time.
int frames_of(ServedRoom& room, int turns) {
  const auto all = [&] {
    int frames = 0;
    for (const auto& visitor : room.visitors) frames += visitor->viewer().frames;
    return frames;
  };
  const int before = all();
  for (int i = 0; i < turns; ++i) room.turn();
  return all() - before;
}

TEST(ServedLevels, each_visitor_has_a_cut_of_its_own_and_they_do_not_fight) {
  ServedRoom room(3, 1, kBudget);
  for (int number = 1; number <= 3; ++number) move(room, number, 2.0 * number * number);
  for (int number = 1; number <= 3; ++number) {
    EXPECT_TRUE(room.until([&] { return has_its_cut(room, number); })) << number;
    EXPECT_LE(room.viewer(number).levels->drawn, kBudget);
    EXPECT_GE(room.viewer(number).levels->drawn, kBudget * 9 / 10);
  }
  EXPECT_NE(room.viewer(1).levels->limit, room.viewer(3).levels->limit);
  frames_of(room, 200);                // exact pictures of the views at rest
  EXPECT_EQ(frames_of(room, 100), 0);  // no cut replaces the others'
  move(room, 2, 7);
  EXPECT_TRUE(room.until([&] { return has_its_cut(room, 2); }));
  EXPECT_TRUE(has_its_cut(room, 1));
  EXPECT_TRUE(has_its_cut(room, 3));
}

TEST(ServedLevels, the_page_says_the_pages_that_are_in_memory) {
  ServedRoom room(1, 1, kBudget);
  ASSERT_TRUE(room.until([&] { return has_its_cut(room, 1); }));
  const std::string state = state_message({}, state_sections(room.of(1), room.small.opened), 1);
  EXPECT_THAT(state, HasSubstr("1 of 1 pages, 0 missing"));
  EXPECT_THAT(state, HasSubstr("levels of detail"));
}

TEST(ServedLevels, a_visitor_goes_from_tree_to_tree_and_back) {
  ServedRoom room(2, 2, kBudget);
  for (const std::size_t scene : {1, 0, 1, 0}) {
    move(room, 1, 4, scene);
    EXPECT_TRUE(room.until([&] { return has_its_cut(room, 1); })) << scene;
    EXPECT_TRUE(room.until([&] { return has_its_cut(room, 2); })) << scene;
  }
}

TEST(ServedLevels, visitors_come_and_go) {
  ServedRoom room(2, 1, kBudget);
  for (int number = 1; number <= 2; ++number)
    ASSERT_TRUE(room.until([&] { return has_its_cut(room, number); }));
  room.pictures().forget(2);
  move(room, 1, 9);
  EXPECT_TRUE(room.until([&] { return has_its_cut(room, 1); }));
  room.add();
  move(room, 3, 3);
  EXPECT_TRUE(room.until([&] { return has_its_cut(room, 3); }));
}

TEST(ServedLevels, a_job_awaits_its_cut_and_leaves_the_others_alone) {
  ServedRoom room(2, 1, kBudget);
  for (int number = 1; number <= 2; ++number)
    ASSERT_TRUE(room.until([&] { return has_its_cut(room, number); }));
  std::atomic<unsigned> drawn = 0;
  room.pictures().run(1, 0, [&](RenderContext& context) {
    const Camera camera = look_at({0, 0, -20}, {0, 0, 0}, {0, -1, 0}, 0.9, 64, 48);
    drawn = context.session.renderer->render(camera, context.session.settings).stats.gaussians;
  });
  ASSERT_TRUE(room.until([&] { return drawn > 0; }));
  EXPECT_LE(drawn, kBudget);
  EXPECT_GE(drawn, kBudget * 9 / 10);
  move(room, 1, 5);
  EXPECT_TRUE(room.until([&] { return has_its_cut(room, 1); }));
  EXPECT_TRUE(has_its_cut(room, 2));
}

TEST(ServedLevels, steps_edit_the_pages_for_all_visitors_and_are_undone) {
  ServedRoom room(2, 1, kBudget);
  for (int number = 1; number <= 2; ++number)
    ASSERT_TRUE(room.until([&] { return has_its_cut(room, number); }));
  const auto steps = [&](int number) {
    const auto& pages = room.viewer(number).editing.pages;
    return pages ? pages->size() : 0;
  };
  const CropBox left{glm::vec3(-100), glm::vec3(0, 100, 100)};
  room.of(1).apply({call(action::edit, EditStep{.select = {.tool = SelectTool::box, .box = left}})},
                   room.now);
  ASSERT_TRUE(room.until([&] { return steps(1) == 1 && steps(2) == 1; }));
  EXPECT_TRUE(room.until([&] { return room.viewer(1).levels->selected > 0; }));
  room.of(2).apply({call(action::edit_selected, EditKind::remove)}, room.now);
  ASSERT_TRUE(room.until([&] { return steps(1) == 2 && steps(2) == 2; }));
  EXPECT_EQ(room.viewer(1).scene->edits.steps, 1);
  EXPECT_THAT(state_message({}, state_sections(room.of(1), room.small.opened), 1),
              HasSubstr("edited: each page, levels of detail"));
  EXPECT_TRUE(room.until([&] { return room.viewer(1).levels->selected == 0; }));
  room.of(1).apply({call(action::step_back, true)}, room.now);
  ASSERT_TRUE(room.until([&] { return steps(1) == 1 && steps(2) == 1; }));
  EXPECT_TRUE(room.until([&] { return room.viewer(2).levels->selected > 0; }));
  EXPECT_EQ(room.viewer(2).scene->edits.steps, 0);
}

TEST(ServedLevels, visible_gaussians_are_a_list_of_the_drawn_leaves) {
  ServedRoom room(1, 1, kBudget);
  ASSERT_TRUE(room.until([&] { return has_its_cut(room, 1); }));
  const Viewer& v = room.viewer();
  EditStep step{.select = {.camera = v.camera, .pixels = {{-1, -1}, {64, 48}}}};
  step.select.tool = SelectTool::rectangle;
  room.of(1).apply({call(action::edit, step)}, room.now);
  ASSERT_TRUE(room.until([&] { return v.editing.pages && !v.crop.busy; }));
  const SelectStep& list = v.editing.pages->front().select;
  EXPECT_EQ(list.tool, SelectTool::list);
  std::uint64_t leaves = 0;
  for (const GaussianRun& run : *list.members) leaves += run.count;
  EXPECT_GT(leaves, 0u);
  EXPECT_LT(leaves, kBudget);
  EXPECT_THAT(v.toasts.back().text, HasSubstr(" of the drawn leaves selected; "));
}

TEST(ServedLevels, a_step_that_needs_the_whole_scene_is_refused_in_one_sentence) {
  ServedRoom room(1, 1, kBudget);
  ASSERT_TRUE(room.until([&] { return has_its_cut(room, 1); }));
  room.of(1).apply({call(action::edit, EditStep{.kind = EditKind::floaters})}, room.now);
  ASSERT_TRUE(room.until([&] { return !room.viewer().toasts.empty(); }));
  EXPECT_THAT(room.viewer().toasts.back().text, HasSubstr("needs the whole scene"));
  EXPECT_EQ(room.viewer().editing.pages, nullptr);
}

}  // namespace
}  // namespace qs
