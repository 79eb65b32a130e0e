// SPDX-License-Identifier: MIT
#include "app/viewer/state/layout.h"

#include <algorithm>
#include <string>
#include <vector>

#include <glm/common.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/driven_viewer.h"
#include "app/viewer/state/mode_table.h"

namespace qs {
namespace {

// Every size of windows that the viewer supports, at the scales of their letters.
std::vector<WindowMetrics> windows() {
  std::vector<WindowMetrics> all;
  for (const glm::vec2 size : {glm::vec2(1024, 640), glm::vec2(1280, 720), glm::vec2(1920, 1080),
                               glm::vec2(2560, 1440), glm::vec2(3840, 2160)}) {
    for (const float scale : {1.0f, 1.5f, 2.0f, 2.5f}) {
      if (size.x / scale >= 1000) all.push_back({size, 15 * scale, 23 * scale});
    }
  }
  return all;
}

float area(const Rect& rect) { return rect.empty() ? 0 : rect.size().x * rect.size().y; }

bool overlap(const Rect& a, const Rect& b) {
  return !a.empty() && !b.empty() && area({glm::max(a.low, b.low), glm::min(a.high, b.high)}) > 0;
}

Viewer with_panels(bool left, bool right) {
  test::DrivenScene driven(0);
  Viewer viewer = driven.viewer;
  viewer.panels.hud = viewer.panels.recorder = left;
  viewer.panels.inspector = viewer.panels.info = right;
  return viewer;
}

TEST(Layout, its_parts_fill_the_window_and_do_not_overlap) {
  for (const WindowMetrics& window : windows()) {
    for (const bool left : {false, true}) {
      for (const bool right : {false, true}) {
        const Layout layout = layout_of(with_panels(left, right), window);
        const Rect parts[] = {layout.menu, layout.left, layout.right, layout.status,
                              layout.picture};
        float sum = 0;
        for (const Rect& part : parts) {
          sum += area(part);
          for (const Rect& other : parts) EXPECT_TRUE(part == other || !overlap(part, other));
        }
        EXPECT_FLOAT_EQ(sum, window.size.x * window.size.y);
        const bool one_bar = left && right && 0.4f * window.size.x < 28 * window.letter;
        EXPECT_NE(layout.left.empty(), left);
        EXPECT_NE(layout.right.empty(), right && !one_bar);
        EXPECT_GE(layout.picture.size().x, 0.6f * window.size.x - 1);
        EXPECT_FLOAT_EQ(layout.menu.size().y, window.line);
        EXPECT_FLOAT_EQ(layout.status.size().y, window.line);
        // Three columns of the table of modes take 23 letters.
        EXPECT_TRUE(!left || layout.left.size().x >= 19 * window.letter) << window.size.x;
      }
    }
  }
}

TEST(Layout, bars_take_at_most_two_fifths_of_the_width_and_share_a_narrow_window) {
  for (const glm::vec2 size : {glm::vec2(320, 240), glm::vec2(640, 400), glm::vec2(1024, 576)}) {
    for (const float scale : {0.75f, 1.0f, 1.5f, 3.0f}) {
      const WindowMetrics window{size, 15 * scale, 23 * scale};
      for (const bool left : {false, true}) {
        for (const bool right : {false, true}) {
          Viewer viewer = with_panels(left, right);
          for (const float wide : {0.0f, 500.0f}) {
            viewer.bars = {wide, wide};
            const Layout layout = layout_of(viewer, window);
            EXPECT_GE(layout.picture.size().x, 0.6f * size.x - 1);
            const float least = std::min(14 * window.letter, 0.4f * size.x) - 1;
            EXPECT_TRUE(layout.left.empty() || layout.left.size().x >= least);
            EXPECT_TRUE(layout.right.empty() || layout.right.size().x >= least);
            const bool has_bars = size.y >= 4 * window.line;
            if (has_bars && left && right && 28 * window.letter > 0.4f * size.x) {
              EXPECT_TRUE(layout.right.empty()) << "the left bar has all panels";
              EXPECT_FALSE(layout.left.empty());
            }
          }
        }
      }
    }
  }
}

TEST(Layout, the_ratio_of_the_table_is_seen_in_the_usual_window_of_a_small_screen) {
  const Layout layout = layout_of(with_panels(true, false), {{1024, 576}, 15, 23});
  const float room = (layout.left.size().x - 2 * 12) / 15, padding = 2 * 6.0f / 15;
  const std::vector<TableColumn> columns =
      columns_that_fit(table_columns(with_panels(true, false)), room, padding);
  EXPECT_THAT(titles_of(columns), testing::Contains("vs 3dgs"));
}

TEST(Layout, the_picture_fills_a_window_without_panels) {
  Viewer viewer = with_panels(true, true);
  viewer.panels.all = false;
  const Rect whole{{0, 0}, {1280, 720}};
  EXPECT_EQ(layout_of(viewer, {}).picture, whole);
  EXPECT_TRUE(layout_of(viewer, {}).menu.empty());
  EXPECT_EQ(layout_of(with_panels(false, false), {}).picture, (Rect{{0, 23}, {1280, 697}}));
  EXPECT_EQ(layout_of(Viewer(), {}).picture, (Rect{{0, 23}, {1280, 697}})) << "no scene";
  const Layout flat = layout_of(viewer, {{200, 40}, 15, 23});
  EXPECT_EQ(flat.picture.size(), glm::vec2(200, 40));
}

TEST(Layout, a_bar_has_the_width_that_the_user_gave_it_within_limits) {
  Viewer viewer = with_panels(true, false);
  const auto width = [&](float letters, WindowMetrics window = {}) {
    viewer.bars.left = letters;
    return layout_of(viewer, window).left.size().x;
  };
  EXPECT_FLOAT_EQ(width(0), 448);  // 0.35 of the window
  EXPECT_FLOAT_EQ(width(20), 300);
  EXPECT_FLOAT_EQ(width(20, {{3840, 2160}, 30, 46}), 600);  // as many letters
  EXPECT_FLOAT_EQ(width(1), 210);                           // 14 letters
  EXPECT_FLOAT_EQ(width(500), 512);                         // 0.4 of the window
  viewer.panels.info = true;
  EXPECT_FLOAT_EQ(width(500), 302);  // 14 letters are left to the other bar
}

}  // namespace
}  // namespace qs
