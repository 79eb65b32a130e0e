// SPDX-License-Identifier: MIT
//
// Keyframes and crops stay with their scene; work that would be lost is asked about; changes of the
// keyframes are undone.
#include "app/viewer/state/kept_work.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/driven_viewer.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/preferences.h"
#include "app/viewer/state/crop_actions.h"
#include "app/viewer/state/edit_actions.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

using test::Driven;
using test::DrivenScene;
using test::some_scene;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using namespace action;

void open_scene(Driven& driven, const std::string& path, const std::string& axes = "RDF") {
  ViewedScene scene = some_scene(0);
  scene.path = path;
  scene.axes = axes;
  driven.apply(resize, 640, 480);
  driven.apply(scene_opened, OpenedScene{scene, RenderSettings(), Backend::cpu});
}

void work(Driven& driven) {
  driven.press("K");
  driven.apply(roll, 1.0);
  driven.press("K");
  driven.apply(ease_keyframe, std::size_t{1}, true);
}

// A crop, answered in place of the render thread.
void crop(Driven& driven) {
  driven.apply(choose_crop, std::string("-1,-1,-0.1,1,1,0.125"));
  driven.apply(apply_crop);
  driven.apply([](Viewer& viewer) {
    const EditStep step = viewer.editing.waiting.front();
    viewer.editing.waiting.pop_front();
    viewer.editing.busy = true;
    EditState after(500);
    after.removed.add(7);
    step_done(viewer, step, std::make_shared<const EditState>(after));
  });
}

void expect_same_work(const Viewer& a, const Viewer& b) {
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  EXPECT_EQ(format_camera_path(a.keyframes), format_camera_path(b.keyframes));
}

TEST(KeptWork, keyframes_come_back_with_their_scene) {
  Driven driven;
  open_scene(driven, "/data/a.ply");
  work(driven);
  const Viewer before = driven.viewer;
  open_scene(driven, "/data/b.ply");
  EXPECT_THAT(driven.viewer.keyframes, IsEmpty());
  open_scene(driven, "/data/a.ply");
  expect_same_work(driven.viewer, before);
  const auto restored = [](const Toast& toast) {
    return toast.text == "restored 2 keyframes of this scene";
  };
  EXPECT_EQ(std::ranges::count_if(driven.viewer.toasts, restored), 1);
  // Read again.
  open_scene(driven, "/data/a.ply");
  expect_same_work(driven.viewer, before);
  // In other axes the numbers mean other places.
  open_scene(driven, "/data/a.ply", "RFU");
  EXPECT_THAT(driven.viewer.keyframes, IsEmpty());
  open_scene(driven, "/data/a.ply");
  expect_same_work(driven.viewer, before);
}

TEST(KeptWork, outlives_the_program) {
  Driven driven, later;
  open_scene(driven, "/data/a.ply");
  work(driven);
  driven.apply(set_mode, 3);
  driven.press("H");
  driven.apply(keep_work);
  const std::string text = format_preferences(driven.viewer, {640, 480});
  later.apply([&](Viewer& viewer) {
    glm::ivec2 size(0);
    parse_preferences(text, viewer, size);
  });
  open_scene(later, "/data/a.ply");
  expect_same_work(later.viewer, driven.viewer);
  EXPECT_EQ(later.viewer.heatmap, HeatQuantity::pairs);
  // Without work nothing is kept.
  for (int i = 0; i < 2; ++i) driven.apply(remove_keyframe, std::size_t{0});
  driven.apply(keep_work);
  EXPECT_THAT(driven.viewer.kept_paths, IsEmpty());
  // Settings that were edited by hand are no reason to fail.
  driven.apply([](Viewer& viewer) { viewer.kept_paths["/data/b.ply RDF"] = "[{]"; });
  open_scene(driven, "/data/b.ply");
  EXPECT_THAT(driven.viewer.keyframes, IsEmpty());
}

TEST(KeptWork, a_page_s_visitors_keep_their_keyframes) {
  Driven driven;
  driven.apply([](Viewer& viewer) { viewer.is_remote = true; });
  open_scene(driven, "/data/a.ply");
  work(driven);
  open_scene(driven, "/data/b.ply");
  open_scene(driven, "/data/a.ply");
  EXPECT_THAT(driven.viewer.keyframes, SizeIs(2));
}

TEST(Leaving, asks_only_about_what_would_be_lost) {
  Driven driven;
  open_scene(driven, "/data/a.ply");
  work(driven);
  crop(driven);
  driven.press("Ctrl+Q");
  EXPECT_EQ(driven.quits, 0) << "the edits are written first";
  EXPECT_TRUE(driven.viewer.editing.kept);
  driven.apply(leave, std::filesystem::path());  // as the thread that wrote them reports
  EXPECT_EQ(driven.quits, 1) << "the work is kept";
  driven.apply([](Viewer& viewer) { viewer.keeps_work = false; });
  driven.press("Ctrl+Q");
  EXPECT_EQ(driven.quits, 1);
  ASSERT_TRUE(driven.viewer.leaving);
  EXPECT_TRUE(driven.viewer.has_dialog());
  EXPECT_EQ(unsaved_text(driven.viewer, ""), "2 keyframes and a crop");
  driven.apply(leave_now, std::filesystem::path(), false);
  EXPECT_EQ(driven.quits, 2);
  EXPECT_FALSE(driven.viewer.leaving);
  driven.apply(action::open, std::filesystem::path("/data/cameras.json"));
  EXPECT_THAT(driven.opened, SizeIs(1)) << "joins the scene";
  driven.apply(action::open, std::filesystem::path("/data/b.ply"));
  EXPECT_THAT(driven.opened, SizeIs(1));
  EXPECT_EQ(driven.viewer.leaving, "/data/b.ply");
}

TEST(Leaving, saves_first_and_stays_until_it_is_saved) {
  Driven driven;
  open_scene(driven, "/data/a.ply");
  work(driven);
  crop(driven);
  driven.apply([](Viewer& viewer) { viewer.keeps_work = false; });
  driven.apply(leave, std::filesystem::path());
  driven.apply(save_and_leave, std::filesystem::path());
  EXPECT_THAT(driven.written, SizeIs(1)) << "the path";
  EXPECT_THAT(driven.jobs, SizeIs(1)) << "the cropped scene";
  EXPECT_EQ(driven.quits, 0) << "once it is written";
  driven.apply(choose_crop, std::string("nothing"));
  driven.apply(save_and_leave, std::filesystem::path());
  EXPECT_EQ(driven.quits, 1);
}

TEST(Leaving, a_film_or_zoom_that_runs_is_asked_about_and_results_before_the_end) {
  Driven driven;
  open_scene(driven, "/data/a.ply");
  driven.apply(show_progress, Loading{"/data/a.mp4", kFilming, 0.31f});
  driven.apply(action::open, std::filesystem::path("/data/b.ply"));
  ASSERT_TRUE(driven.viewer.leaving);
  EXPECT_EQ(unsaved_text(driven.viewer, *driven.viewer.leaving), "a film of which 31 % are drawn");
  driven.apply(save_and_leave, std::filesystem::path("/data/b.ply"));
  EXPECT_EQ(driven.stopped, 1);
  EXPECT_THAT(driven.opened, SizeIs(1));
  driven.apply(end_progress);
  driven.apply(results_kept, std::string("zoom"), std::string("disk: is full"));
  EXPECT_EQ(driven.viewer.toasts.back().offer, ToastOffer::save_results);
  EXPECT_THAT(driven.viewer.toasts.back().text, HasSubstr("the zoom stays in memory"));
  driven.apply(action::open, std::filesystem::path("/data/c.ply"));
  EXPECT_THAT(driven.opened, SizeIs(2)) << "they stay in memory";
  driven.press("Ctrl+Q");
  EXPECT_EQ(driven.quits, 0);
  EXPECT_EQ(unsaved_text(driven.viewer, ""), "a zoom");
  driven.apply(save_and_leave, std::filesystem::path());
  EXPECT_TRUE(driven.viewer.panels.open);
  EXPECT_EQ(driven.viewer.choosing, qs::Choosing::results);
  driven.apply(results_saved);
  driven.press("Ctrl+Q");
  EXPECT_EQ(driven.quits, 1);
}

TEST(KeyframeHistory, takes_changes_back_and_repeats_them) {
  DrivenScene driven(0);
  const auto path = [&] { return format_camera_path(driven.viewer.keyframes); };
  std::vector<std::string> paths = {path()};
  const auto change = [&](auto... what) {
    driven.apply(what...);
    paths.push_back(path());
  };
  change(add_keyframe);
  driven.apply(roll, 1.0);
  change(add_keyframe);
  change(delay_keyframe, std::size_t{1}, 3.0);
  change(ease_keyframe, std::size_t{0}, true);
  change(remove_keyframe, std::size_t{0});
  change(set_keyframes, std::vector<Keyframe>(2, {7, driven.viewer.camera}));
  for (std::size_t i = paths.size() - 1; i-- > 0;) {
    driven.press("Ctrl+Z");
    EXPECT_EQ(path(), paths[i]) << i;
  }
  driven.press("Ctrl+Z");
  EXPECT_EQ(driven.viewer.toasts.back().text, "no change of the keyframes is left");
  for (std::size_t i = 1; i < paths.size(); ++i) {
    driven.press("Ctrl+Shift+Z");
    EXPECT_EQ(path(), paths[i]) << i;
  }
  driven.press("Ctrl+Z");
  driven.press("K");
  driven.press("Ctrl+Shift+Z");
  EXPECT_EQ(driven.viewer.toasts.back().text, "no change of the keyframes is left")
      << "another change came";
}

TEST(KeyframeHistory, a_time_that_is_dragged_is_one_step) {
  DrivenScene driven(0);
  driven.press("K");
  driven.press("K");
  const std::string before = format_camera_path(driven.viewer.keyframes);
  for (int i = 1; i < 30; ++i) {
    driven.apply(tick, Turn{0.1 * i}, 0.1);
    driven.apply(delay_keyframe, std::size_t{1}, 1 + 0.1 * i);
  }
  driven.press("Ctrl+Z");
  EXPECT_EQ(format_camera_path(driven.viewer.keyframes), before);
}

}  // namespace
}  // namespace qs
