// SPDX-License-Identifier: MIT
//
// Messages: written files, errors that are over, and paths that are shortened.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/driven_viewer.h"
#include "app/viewer/state/panel_text.h"

namespace qs {
namespace {

using test::Driven;
using test::some_scene;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using namespace action;

TEST(Messages, a_written_file_has_its_absolute_path_in_toast_and_log) {
  Driven driven;
  driven.apply(tick, Turn{1}, 0.0);
  driven.apply(notify_file, std::filesystem::path("./film/../a.mp4"), std::string(": done"));
  const std::filesystem::path path = std::filesystem::current_path() / "a.mp4";
  ASSERT_THAT(driven.viewer.toasts, SizeIs(1));
  const Toast& toast = driven.viewer.toasts[0];
  EXPECT_EQ(toast.text, "wrote " + path.string() + ": done");
  EXPECT_EQ(toast.path, path);
  EXPECT_FALSE(toast.error);
  EXPECT_EQ(driven.viewer.log.back().path, path);
  EXPECT_EQ(driven.viewer.log.back().text, toast.text);
  EXPECT_FALSE(driven.viewer.log.back().error);
  driven.apply(tick, Turn{15.9}, 0.0);
  EXPECT_THAT(driven.viewer.toasts, SizeIs(1)) << "long enough to press a button";
  driven.apply(&Host::open_with_desktop, path);
  EXPECT_THAT(driven.opened_outside, ElementsAre(path));
  driven.apply(copy_text, path.string());
  EXPECT_EQ(driven.text, path.string());
}

TEST(Messages, stay_while_the_mouse_holds_them_and_a_moment_longer) {
  Driven driven;
  driven.apply(tick, Turn{1}, 0.0);
  driven.apply(notify, "a");
  driven.apply(hold_toasts, true);
  const auto left_at = [&](double now) {
    driven.apply(tick, Turn{now}, 0.0);
    return driven.viewer.toasts.size();
  };
  EXPECT_EQ(left_at(100), 1u);
  driven.apply(hold_toasts, false);
  EXPECT_EQ(left_at(101.9), 1u);
  EXPECT_EQ(left_at(102.1), 0u);
  driven.apply(notify, "b");
  driven.apply(notify, "c");
  driven.apply(dismiss_toast, std::size_t{7});
  driven.apply(dismiss_toast, std::size_t{0});
  ASSERT_THAT(driven.viewer.toasts, SizeIs(1));
  EXPECT_EQ(driven.viewer.toasts[0].text, "c");
}

TEST(Messages, why_a_file_was_not_opened_goes_when_something_opens) {
  const OpeningResult good[] = {
      OpenedScene{some_scene(1), RenderSettings(), Backend::cpu}, SceneBeside{"/data/other.ply", 5},
      OpenedPath{{{0, some_scene(1).cameras[0]}, {1, some_scene(1).cameras[0]}}}};
  for (const OpeningResult& result : good) {
    test::DrivenScene driven(1);
    driven.apply(notify_error, "the disk is full");
    driven.apply(opening_ended, OpeningResult(OpeningFailed{"b.ply: not a scene"}));
    driven.apply(opening_ended, OpeningResult(OpeningFailed{"c.ply: not a scene"}));
    driven.apply(opening_ended, OpeningResult(OpeningCancelled{}));
    ASSERT_THAT(driven.viewer.toasts, SizeIs(3));
    driven.apply(opening_ended, result);
    int errors = 0;
    for (const Toast& toast : driven.viewer.toasts) errors += toast.error ? 1 : 0;
    EXPECT_EQ(errors, 1) << "another error stays";
    EXPECT_EQ(driven.viewer.toasts[0].text, "the disk is full");
  }
}

TEST(Hints, go_when_they_are_followed_and_after_their_time) {
  test::DrivenScene driven(1);
  driven.apply([](Viewer& viewer) { viewer.hints = {true, true, true, true}; });
  const auto tick_at = [&](double now) {
    Turn turn;
    turn.now = now;
    driven.apply(action::tick, turn, 0.1);
    return driven.viewer.hints.any();
  };
  EXPECT_TRUE(tick_at(5));
  driven.apply(action::set_mode, find_culler("3dgs"));
  EXPECT_FALSE(driven.viewer.hints.modes);
  EXPECT_TRUE(tick_at(5 + kHintSeconds));
  EXPECT_FALSE(tick_at(5.1 + kHintSeconds));
}

TEST(Messages, long_paths_lose_their_middle) {
  EXPECT_EQ(shortened_middle("short", 5), "short");
  EXPECT_EQ(shortened_middle("", 5), "");
  EXPECT_EQ(shortened_middle("/home/someone/scenes/a.png", 15), "/hom\u2026enes/a.png");
  EXPECT_EQ(shortened_middle("abcdef", 0), "\u2026ef") << "at least 3 letters";
  EXPECT_EQ(shortened_middle("\u00e4\u00f6\u00fc\u00e4\u00f6\u00fc", 4),
            "\u00e4\u2026\u00f6\u00fc");
  EXPECT_EQ(letters_of("\u00e4a\u2026"), 3u);
  for (std::size_t most = 3; most < 30; ++most)
    EXPECT_EQ(letters_of(shortened_middle(std::string(100, 'x'), most)), most);
}

}  // namespace
}  // namespace qs
