// SPDX-License-Identifier: MIT
//
// The parts of the viewer's loop without a window: pacing, scripts, window grabs, options,
// requests to the render thread, the facts of a scene.
#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/viewer/memory_use.h"
#include "app/viewer/pacing.h"
#include "app/viewer/preferences.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/scene_reading.h"
#include "app/viewer/view_options.h"
#include "app/viewer/window/input_script.h"
#include "app/viewer/window/presenter.h"
#include "base/quit_signals.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "support/paths.h"
#include "support/pool.h"
#include "support/recording_host.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// ---- pacing -------------------------------------------------------------------------------------
Surroundings at(double now) { return {now, -1e9, false, false}; }

Pacing drawn_at(const Viewer& viewer, double now) {
  Pacing pacing;
  pacing.begin_drawing(viewer);
  pacing.end_drawing(viewer, now);
  return pacing;
}

TEST(Pacing, draws_first_then_rests_until_something_changes) {
  Viewer viewer;
  viewer.now = 10;
  EXPECT_EQ(Pacing().sleep_seconds(viewer, at(10), false), 0);
  Pacing pacing = drawn_at(viewer, 10);
  EXPECT_FALSE(pacing.wants_to_draw(viewer, at(10)));
  EXPECT_TRUE(pacing.rests(viewer, at(10), false));
  EXPECT_EQ(pacing.sleep_seconds(viewer, at(10), false), 0.5);
  pacing.note_change(viewer, 10);
  EXPECT_TRUE(pacing.wants_to_draw(viewer, at(10)));
  pacing.begin_drawing(viewer);
  EXPECT_TRUE(pacing.wants_to_draw(viewer, at(10.3)));  // for a moment
  EXPECT_FALSE(pacing.wants_to_draw(viewer, at(10.4)));
}

TEST(Pacing, does_not_rest_while_work_is_left) {
  Viewer viewer;
  viewer.now = 10;
  const Pacing pacing = drawn_at(viewer, 10);
  EXPECT_EQ(pacing.sleep_seconds(viewer, at(10), true), 0.01);  // numbers are missing
  Surroundings pending = at(10);
  pending.has_pending = true;
  EXPECT_EQ(pacing.sleep_seconds(viewer, pending, false), 0.01);
  viewer.last_motion = 9.77;  // neither moving nor still
  EXPECT_EQ(pacing.sleep_seconds(viewer, at(10), false), 0.01);
  viewer.last_motion = 9.9;
  EXPECT_EQ(pacing.sleep_seconds(viewer, at(10), false), 0);
}

TEST(Pacing, draws_after_an_event_and_when_a_message_comes_or_goes) {
  Viewer viewer;
  const Pacing pacing = drawn_at(viewer, 10);
  Surroundings event = at(10);
  event.last_event = 9.7;
  EXPECT_TRUE(pacing.wants_to_draw(viewer, event));
  event.last_event = 9.6;
  EXPECT_FALSE(pacing.wants_to_draw(viewer, event));
  viewer.toasts.push_back({"hello"});
  EXPECT_TRUE(pacing.wants_to_draw(viewer, at(10)));
  const Pacing shown = drawn_at(viewer, 10);
  EXPECT_FALSE(shown.wants_to_draw(viewer, at(10)));
  viewer.toasts.clear();
  EXPECT_TRUE(shown.wants_to_draw(viewer, at(10)));
}

TEST(Pacing, a_change_during_a_measurement_is_drawn_once_and_spares_the_measurement) {
  Viewer viewer;
  viewer.measuring = true;
  Pacing pacing = drawn_at(viewer, 10);
  pacing.note_change(viewer, 10);
  EXPECT_TRUE(pacing.wants_to_draw(viewer, at(10)));
  EXPECT_FALSE(pacing.begin_drawing(viewer));
  EXPECT_FALSE(pacing.wants_to_draw(viewer, at(10.1)));
  EXPECT_TRUE(pacing.begin_drawing(viewer));  // drawn for another reason: the numbers are void
}

TEST(Pacing, the_end_of_a_measurement_is_drawn_without_an_action) {
  Viewer viewer;
  Pacing idle = drawn_at(viewer, 10);
  viewer.measuring = true;  // the window does not say so yet: nothing to take back
  EXPECT_FALSE(idle.wants_to_draw(viewer, at(11)));
  Pacing pacing = drawn_at(viewer, 10);
  EXPECT_FALSE(pacing.wants_to_draw(viewer, at(11)));
  viewer.measuring = false;
  EXPECT_TRUE(pacing.wants_to_draw(viewer, at(11)));
  EXPECT_FALSE(pacing.rests(viewer, at(11), false));
  pacing.begin_drawing(viewer);
  EXPECT_FALSE(pacing.wants_to_draw(viewer, at(11)));
}

TEST(Pacing, a_zoom_is_recorded_without_continuous_drawing) {
  Viewer viewer;
  viewer.on_demand = false;
  viewer.playback.running = true;
  Pacing pacing = drawn_at(viewer, 10);
  EXPECT_TRUE(pacing.wants_to_draw(viewer, at(11)));
  viewer.zoom.running = true;
  EXPECT_FALSE(pacing.wants_to_draw(viewer, at(11)));
  pacing.note_change(viewer, 11);  // a step
  EXPECT_TRUE(pacing.wants_to_draw(viewer, at(11)));
  pacing.begin_drawing(viewer);
  EXPECT_FALSE(pacing.wants_to_draw(viewer, at(11)));
}

TEST(Pacing, continuous_drawing_waits_for_the_frame_but_not_long) {
  Viewer viewer;
  viewer.on_demand = false;
  const Pacing pacing = drawn_at(viewer, 10);
  Surroundings busy = at(10.01);
  busy.render_busy = true;
  EXPECT_TRUE(pacing.frame_comes_first(viewer, busy));
  EXPECT_EQ(pacing.sleep_seconds(viewer, busy, false), 0.03);
  busy.now = 10.04;
  EXPECT_FALSE(pacing.frame_comes_first(viewer, busy));
  EXPECT_FALSE(pacing.frame_comes_first(viewer, at(10.01)));
}

TEST(Pacing, reading_has_pauses_between_drawings_but_a_new_picture_is_drawn_at_once) {
  Viewer viewer;
  viewer.loading.emplace();
  const Pacing pacing = drawn_at(viewer, 10);
  EXPECT_TRUE(pacing.wants_to_draw(viewer, at(10.05)));
  EXPECT_TRUE(pacing.frame_comes_first(viewer, at(10.05)));
  EXPECT_GT(pacing.sleep_seconds(viewer, at(10.05), false), 0);
  EXPECT_FALSE(pacing.frame_comes_first(viewer, at(10.07)));
  EXPECT_EQ(pacing.sleep_seconds(viewer, at(10.07), false), 0);
  ++viewer.frames;
  EXPECT_FALSE(pacing.frame_comes_first(viewer, at(10.01)));
}

TEST(Pacing, a_moving_camera_s_window_is_drawn_once_for_every_picture) {
  Viewer viewer;
  viewer.now = viewer.last_motion = 10;
  const Pacing pacing = drawn_at(viewer, 10);
  Surroundings busy = at(10.01);
  busy.render_busy = true;
  EXPECT_TRUE(pacing.frame_comes_first(viewer, busy));
  ++viewer.frames;
  EXPECT_FALSE(pacing.frame_comes_first(viewer, busy));  // while the next frame is rendered
  --viewer.frames;
  viewer.last_motion = 9;
  EXPECT_FALSE(pacing.frame_comes_first(viewer, busy));
}

TEST(Pacing, the_display_s_rate_is_smoothed_and_a_pause_is_none) {
  Viewer viewer;
  viewer.on_demand = false;
  Pacing pacing = drawn_at(viewer, 10);
  const auto new_picture = [&](double now) {
    ++viewer.frames;
    return pacing.end_drawing(viewer, now);
  };
  EXPECT_NEAR(new_picture(10.02), 50, 1e-6);
  EXPECT_NEAR(new_picture(10.03), 0.9 * 50 + 0.1 * 100, 1e-6);
  EXPECT_EQ(new_picture(10.5), 0);
  EXPECT_NEAR(new_picture(10.6), 10, 1e-6);
  viewer.on_demand = true;
  EXPECT_EQ(new_picture(10.62), 0);
}

TEST(Pacing, the_display_s_rate_counts_pictures_and_not_drawings_of_the_window) {
  Viewer viewer;
  viewer.on_demand = false;
  Pacing pacing = drawn_at(viewer, 10);
  // The window is drawn every 10 ms, and a picture takes 100 ms.
  double rate = 0;
  for (int turn = 1; turn <= 100; ++turn) {
    if (turn % 10 == 0) ++viewer.frames;
    rate = pacing.end_drawing(viewer, 10 + 0.01 * turn);
  }
  EXPECT_NEAR(rate, 10, 1e-6);
  // The loop waits a whole second for a picture that takes a second.
  for (int turn = 1; turn < 100; ++turn) rate = pacing.end_drawing(viewer, 11 + 0.01 * turn);
  EXPECT_NEAR(rate, 1 / 0.99, 1e-6);
}

// ---- requests -----------------------------------------------------------------------------------
TEST(FrameRequests, numbers_are_missing_only_where_they_can_be_seen_and_measured) {
  Viewer viewer;
  viewer.panels.hud = true;
  viewer.scene.emplace();
  viewer.shown.version = viewer.version;
  EXPECT_TRUE(numbers_are_missing(viewer));
  EXPECT_FALSE(is_settled(viewer));
  viewer.panels.hud = false;
  EXPECT_FALSE(numbers_are_missing(viewer));
  EXPECT_TRUE(is_settled(viewer));
  viewer.shown.divisor = 2;
  EXPECT_FALSE(is_settled(viewer));
  viewer.shown.divisor = 1;
  viewer.playback.running = true;
  EXPECT_FALSE(is_settled(viewer));
  viewer.panels.hud = true;
  EXPECT_TRUE(numbers_are_missing(viewer));
  viewer.zoom.running = true;
  EXPECT_FALSE(numbers_are_missing(viewer));
  EXPECT_TRUE(is_settled(Viewer()));  // an empty window
}

TEST(FrameRequests, numbers_are_wanted_until_they_are_precise_but_a_settled_view_has_the_first) {
  Viewer viewer;
  viewer.panels.hud = true;
  viewer.scene.emplace();
  viewer.shown.version = viewer.version;
  EXPECT_TRUE(numbers_are_wanted(viewer));
  viewer.numbers.version = viewer.view_version;
  viewer.numbers.rows.resize(2);
  viewer.numbers.rows[0].mode = "3dgs";
  viewer.numbers.rows[0].round_ms = {1, 2, 1, 2, 1};
  viewer.numbers.rows[1].mode = "adr";
  viewer.numbers.rows[1].round_ms = {2, 1, 2, 1, 2};
  EXPECT_TRUE(numbers_are_wanted(viewer));
  EXPECT_FALSE(numbers_are_missing(viewer));
  EXPECT_TRUE(counts_are_missing(viewer));
  EXPECT_FALSE(is_settled(viewer));
  viewer.counts.view_version = viewer.view_version;
  EXPECT_TRUE(is_settled(viewer));
  viewer.panels.hud = false;
  EXPECT_FALSE(numbers_are_wanted(viewer));
  viewer.panels.hud = true;
  viewer.numbers.complete = true;
  EXPECT_FALSE(numbers_are_wanted(viewer));
}

TEST(FrameRequests, a_scene_beside_is_drawn_as_the_one_in_the_window) {
  Viewer viewer;
  viewer.panels.split = true;
  viewer.settings.mode = find_culler("exact");
  viewer.split.other.mode = find_culler("adr");
  EXPECT_FALSE(full_frame(viewer).beside);
  viewer.beside = SceneBeside{"/data/other.ply", 70};
  EXPECT_TRUE(full_frame(viewer).beside);
  EXPECT_EQ(full_frame(viewer).other, viewer.variant());
  viewer.panels.split = false;
  EXPECT_FALSE(full_frame(viewer).other);
}

TEST(FrameRequests, a_split_window_asks_for_the_other_variant_and_the_heat_map) {
  Viewer viewer;
  viewer.heatmap = HeatQuantity::evaluated;
  viewer.peeking = true;
  viewer.previous_mode = 3;
  EXPECT_EQ(full_frame(viewer).heatmap, HeatQuantity::evaluated);
  EXPECT_EQ(full_frame(viewer).settings.mode, 3);
  EXPECT_FALSE(full_frame(viewer).other);
  viewer.panels.split = true;
  EXPECT_EQ(full_frame(viewer).heatmap, HeatQuantity::evaluated);
  EXPECT_EQ(full_frame(viewer).other, viewer.split.other);
  viewer.shows_grid = true;
  EXPECT_TRUE(full_frame(viewer).grid);
  EXPECT_FALSE(full_frame(viewer).other);
}

TEST(QuitSignals, note_a_signal_and_leave_the_second_one_alone) {
  for (const int signal : {SIGTERM, SIGINT}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    {
      const QuitSignals signals;
      EXPECT_FALSE(QuitSignals::arrived());
      raise(signal);
      EXPECT_TRUE(QuitSignals::arrived());
      struct sigaction next {};
      sigaction(signal, nullptr, &next);
      EXPECT_EQ(next.sa_handler, SIG_DFL);
    }
    struct sigaction after {};
    sigaction(signal, nullptr, &after);
    EXPECT_EQ(after.sa_handler, before.sa_handler);
  }
}

TEST(MemoryUse, knows_this_process) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "ThreadSanitizer's shadow memory counts too";
#endif
  const std::uint64_t before = process_bytes();
  const std::vector<char> block(std::size_t{64} << 20, 1);
  EXPECT_NEAR(static_cast<double>(process_bytes() - before), static_cast<double>(block.size()),
              static_cast<double>(block.size()) / 4);
  EXPECT_EQ(gpu_bytes(1000), 0u);
}

TEST(MemoryWatch, measures_on_its_own_thread_and_once_in_its_pause) {
  std::atomic<int> calls = 0;
  std::atomic<bool> elsewhere = false;
  const auto measure = [&, here = std::this_thread::get_id()] {
    elsewhere = std::this_thread::get_id() != here;
    return static_cast<std::uint64_t>(++calls);
  };
  MemoryWatch watch(measure, std::chrono::hours(1));
  EXPECT_EQ(watch.bytes(), 0u);
  watch.ask();
  while (watch.bytes() == 0) std::this_thread::yield();
  for (int i = 0; i < 1000; ++i) watch.ask();
  EXPECT_EQ(watch.bytes(), 1u);
  EXPECT_TRUE(elsewhere);
  MemoryWatch quick(measure, std::chrono::milliseconds(0));
  quick.ask();
  while (quick.bytes() == 0) std::this_thread::yield();
  const std::uint64_t first = quick.bytes();
  quick.ask();
  while (quick.bytes() == first) std::this_thread::yield();
}

// ---- scripts and grabs --------------------------------------------------------------------------
class ScriptPlayerTest : public testing::Test {
 protected:
  ScriptPlayer player(const std::string& script) {
    std::ofstream(folder_ / "script") << script;
    return ScriptPlayer(folder_ / "script");
  }

  TemporaryFolder folder_;
  test::RecordingHost host_;
  Viewer viewer_;
  bool rests_ = true;
  std::function<bool()> at_rest_ = [this] { return rests_; };
};

TEST_F(ScriptPlayerTest, carries_out_the_program_s_commands_itself) {
  ScriptPlayer script = player("shot a b.png\nstate s.json\nquit\n");
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(script.next(viewer_, host_, at_rest_));
  EXPECT_TRUE(script.done());
  EXPECT_THAT(host_.grabs, testing::ElementsAre("a b.png"));
  EXPECT_EQ(parse_json(host_.written["s.json"], "test")["mode"], "quadbox");
  EXPECT_EQ(host_.quits, 1);
}

TEST_F(ScriptPlayerTest, waits_until_nothing_is_left_and_not_for_ever) {
  ScriptPlayer script = player("wait\nkey H\nwait\n");
  rests_ = false;
  EXPECT_FALSE(script.next(viewer_, host_, at_rest_));
  rests_ = true;
  EXPECT_FALSE(script.next(viewer_, host_, at_rest_));
  const auto step = script.next(viewer_, host_, at_rest_);
  ASSERT_TRUE(step);
  EXPECT_EQ(step->command, "key");
  rests_ = false;
  viewer_.now = 119;
  EXPECT_FALSE(script.next(viewer_, host_, at_rest_));
  viewer_.now = 121;
  EXPECT_THROW(script.next(viewer_, host_, at_rest_), Error);
}

TEST_F(ScriptPlayerTest, sleeps_and_holds_keys_for_seconds) {
  ScriptPlayer script = player("hold W 0.5\nsleep 2\ndrag 3 4 left\n");
  EXPECT_EQ(script.next(viewer_, host_, at_rest_)->command, "press");
  EXPECT_FALSE(script.next(viewer_, host_, at_rest_));
  viewer_.now = 0.5;
  EXPECT_EQ(script.next(viewer_, host_, at_rest_)->command, "release");
  EXPECT_FALSE(script.next(viewer_, host_, at_rest_));  // sleep
  viewer_.now = 2.4;
  EXPECT_FALSE(script.next(viewer_, host_, at_rest_));
  viewer_.now = 2.5;
  EXPECT_EQ(script.next(viewer_, host_, at_rest_)->command, "press");
  EXPECT_THAT(script.next(viewer_, host_, at_rest_)->words, testing::ElementsAre("3", "4"));
  EXPECT_EQ(script.next(viewer_, host_, at_rest_)->command, "release");
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
  EXPECT_THAT(error_of("move 3\n"), HasSubstr("line 1: expected 'move X Y'"));
}

TEST(InputScript, every_command_is_documented) {
  const std::string text = read_text_file(test::source_path("docs/viewer.md"), 1 << 20);
  for (const ScriptCommand& command : kScriptCommands)
    EXPECT_THAT(text, HasSubstr(std::string("`") + command.name));
}

TEST(WindowGrab, writes_once_and_reports_what_went_wrong) {
  const TemporaryFolder folder;
  test::RecordingHost host;
  ViewerStore store{Viewer()};
  WindowGrab grab;
  const auto take = [&] {
    Actions actions;
    grab.take([] { return Image(4, 3, 3); }, actions);
    for (const Action& action : actions) store.apply(action, host);
  };
  take();
  EXPECT_THAT(store.viewer().toasts, IsEmpty());
  grab.request(folder / "deep/a.png", true);
  EXPECT_TRUE(grab.requested());
  take();
  take();
  EXPECT_FALSE(grab.requested());
  EXPECT_EQ(read_image(folder / "deep/a.png").width, 4);
  ASSERT_THAT(store.viewer().toasts, SizeIs(1));
  EXPECT_EQ(store.viewer().toasts[0].path, folder / "deep/a.png");
  std::ofstream(folder / "file") << "not a folder";
  grab.request(folder / "file/b.png", false);
  take();
  ASSERT_THAT(store.viewer().toasts, SizeIs(2));
  EXPECT_TRUE(store.viewer().toasts[1].error);
}

// ---- options and files --------------------------------------------------------------------------
TEST(ViewOptions, overrule_the_preferences) {
  const TemporaryFolder folder;
  Viewer kept;
  kept.on_demand = false;
  write_preferences(folder / "viewer.json", kept, {640, 480});
  ViewOptions options;
  options.settings = folder / "viewer.json";
  options.frame.backend = Backend::cpu;
  options.frame.modes = {find_culler("exact")};
  options.vsync = false;
  options.beside = "adr";
  options.frame.cameras = "cameras.json";
  glm::ivec2 size(1280, 720);
  const Viewer viewer = initial_viewer(options, size);
  EXPECT_EQ(size, glm::ivec2(640, 480));
  EXPECT_EQ(viewer.mode(), find_culler("exact"));
  EXPECT_FALSE(viewer.vsync);
  EXPECT_FALSE(viewer.on_demand);
  EXPECT_TRUE(viewer.panels.split);
  EXPECT_EQ(viewer.split.other.mode, find_culler("adr"));
  EXPECT_FALSE(viewer.restores_views);
  EXPECT_TRUE(viewer.offers_views);
  options.frame.size = glm::ivec2(800, 600);
  initial_viewer(options, size);
  EXPECT_EQ(size, glm::ivec2(800, 600));
  options.script = "script";
  EXPECT_FALSE(initial_viewer(options, size).offers_views);
  std::ofstream(folder / "viewer.json") << "{";
  EXPECT_THAT(initial_viewer(options, size).toasts.at(0).text, HasSubstr("ignored"));
  options.beside = "best";
  EXPECT_THROW(initial_viewer(options, size), Error);
}

TEST(SceneFacts, up_is_the_convention_s_in_a_cloud_without_a_floor_unless_the_file_says_so) {
  Scene scene;
  scene.path = "/nowhere/scene.ply";
  scene.cloud = test::random_cloud(50, 0, 1);
  EXPECT_EQ(view_facts(scene, std::nullopt, test::pool(1)).up, glm::dvec3(0, -1, 0));
  scene.vertical_axis = "z";
  EXPECT_EQ(view_facts(scene, std::nullopt, test::pool(1)).up, glm::dvec3(0, 0, 1));
}

}  // namespace
}  // namespace qs
