// SPDX-License-Identifier: MIT
//
// Bookmarks: views of a scene that the user named.
#include <algorithm>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/driven_viewer.h"
#include "app/viewer/panel_model/panel_model.h"
#include "app/viewer/preferences.h"

namespace qs {
namespace {

using test::Driven;
using test::DrivenScene;
using test::some_scene;
using testing::ElementsAre;
using testing::IsEmpty;
using namespace action;

std::vector<std::string> names(const Viewer& viewer) {
  std::vector<std::string> found;
  for (const auto& [name, camera] : bookmarks_of(viewer)) found.push_back(name);
  return found;
}

// The bookmarks "door", at the first view, and "view 2", one step to the right of it.
void mark(Driven& driven) {
  driven.press("Ctrl+D");
  EXPECT_TRUE(driven.viewer.panels.cameras) << "where it can be renamed";
  EXPECT_THAT(names(driven.viewer), ElementsAre("view 1"));
  driven.apply(name_bookmark, std::size_t{0}, std::string("door"));
  driven.apply(shift, glm::dvec3(1, 0, 0));
  driven.press("Ctrl+D");
  EXPECT_THAT(names(driven.viewer), ElementsAre("door", "view 2"));
}

TEST(Bookmarks, go_to_their_views_and_backspace_goes_back) {
  DrivenScene driven(0);
  const glm::dvec3 first = driven.viewer.camera.position();
  mark(driven);
  const glm::dvec3 second = driven.viewer.camera.position();
  EXPECT_GT(glm::distance(first, second), 0.9);
  driven.apply([](Viewer& viewer) { viewer.animates_moves = true; });
  driven.apply(go_to_bookmark, std::size_t{0});
  EXPECT_TRUE(driven.viewer.travel) << "as to other views, within a moment";
  driven.apply(arrive);
  EXPECT_LT(glm::distance(driven.viewer.camera.position(), first), 1e-9);
  driven.press("Backspace");
  driven.apply(arrive);
  EXPECT_LT(glm::distance(driven.viewer.camera.position(), second), 1e-9);
  driven.apply(go_to_bookmark, std::size_t{2});
  EXPECT_FALSE(driven.viewer.travel) << "there are two";
}

TEST(Bookmarks, are_renamed_and_removed) {
  DrivenScene driven(0);
  mark(driven);
  const Bookmarks before = bookmarks_of(driven.viewer);
  driven.apply(name_bookmark, std::size_t{0}, std::string("window"));
  driven.apply(name_bookmark, std::size_t{2}, std::string("there are two"));
  EXPECT_THAT(names(driven.viewer), ElementsAre("window", "view 2"));
  EXPECT_EQ(bookmarks_of(driven.viewer)[0].second, before[0].second) << "the same view";
  for (const std::size_t index : {2, 0}) driven.apply(remove_bookmark, index);
  EXPECT_THAT(names(driven.viewer), ElementsAre("view 2"));
}

TEST(Bookmarks, stay_with_their_scene_in_its_axes_and_outlive_the_program) {
  DrivenScene driven(0);
  mark(driven);
  ViewedScene other = some_scene(0);
  other.axes = "RFU";
  driven.apply(scene_opened, OpenedScene{other, RenderSettings(), Backend::cpu});
  EXPECT_THAT(names(driven.viewer), IsEmpty()) << "in other axes the cameras mean other places";
  Driven later;
  later.apply([&](Viewer& viewer) {
    glm::ivec2 size(0);
    parse_preferences(format_preferences(driven.viewer, {640, 480}), viewer, size);
  });
  later.apply(resize, 1280, 480);
  later.apply(scene_opened, OpenedScene{some_scene(0), RenderSettings(), Backend::cpu});
  EXPECT_THAT(names(later.viewer), ElementsAre("door", "view 2"));
  // Settings that were edited by hand.
  later.apply([](Viewer& viewer) { viewer.bookmarks.begin()->second[0].second = "{"; });
  later.apply(go_to_bookmark, std::size_t{0});
  EXPECT_TRUE(later.viewer.toasts.back().error);
  later.apply(go_to_bookmark, std::size_t{1});
  EXPECT_EQ(later.viewer.camera.width, 1280) << "at the window's size";
}

// The items of the list of bookmarks.
std::vector<std::vector<block::Item>> listed(const Viewer& viewer) {
  std::vector<std::vector<block::Item>> rows;
  for (const Block& block : camera_blocks(viewer)) {
    const auto* items = std::get_if<block::Items>(&block);
    if (items != nullptr) rows.insert(rows.end(), items->rows.begin(), items->rows.end());
  }
  return rows;
}

TEST(Bookmarks, are_listed_for_a_page_without_a_field_for_their_names) {
  DrivenScene driven(0);
  mark(driven);
  EXPECT_EQ(listed(driven.viewer).size(), 0u) << "the window has fields";
  driven.apply([](Viewer& viewer) { viewer.is_remote = true; });
  ASSERT_EQ(listed(driven.viewer).size(), 2u);
  EXPECT_EQ(listed(driven.viewer)[0].back().label, "door");
  const Control& item = *find_control(listed(driven.viewer)[0].front().control);
  driven.store.apply(*set_control(driven.viewer, item, 0, 0), driven);
  EXPECT_THAT(names(driven.viewer), ElementsAre("view 2"));
}

TEST(Bookmarks, need_a_scene) {
  Driven driven;
  driven.press("Ctrl+D");
  driven.apply(go_to_bookmark, std::size_t{0});
  EXPECT_THAT(driven.viewer.bookmarks, IsEmpty());
}

}  // namespace
}  // namespace qs
