// SPDX-License-Identifier: MIT
//
// The window of a training in another program.
#include <csignal>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/support/driven_viewer.h"
#include "app/support/program_in_window.h"
#include "app/support/run_program.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/training_actions.h"
#include "io/picture/image_file.h"
#include "support/paths.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

struct DrivenRemote : test::Driven {
  DrivenRemote() {
    apply(action::resize, 64, 48);
    apply(action::remote_opened, std::string("gpu7:6009"), std::vector<Camera>());
  }
  void report(const RemoteRun& run) { apply(action::remote_reported, run); }
  std::string fact(const std::string& label) const {
    for (const Fact& fact : remote_facts(viewer)) {
      if (fact.label == label) return fact.value;
    }
    return "";
  }
};

TEST(RemoteWindow, the_panel_says_how_the_training_is) {
  DrivenRemote driven;
  EXPECT_EQ(driven.fact("state"), "connecting");
  RemoteRun run;
  run.address = "gpu7:6009";
  run.is_answering = true;
  run.source = "/data/garden";
  run.metrics = {1234567.0, 0.03125};
  driven.report(run);
  EXPECT_EQ(driven.fact("state"), "running");
  EXPECT_EQ(driven.fact("its data"), "/data/garden");
  EXPECT_EQ(driven.fact("Gaussians"), "1,234,567");
  EXPECT_EQ(driven.fact("loss"), "0.0312");
  run.metrics = {NAN, NAN};
  driven.report(run);
  EXPECT_EQ(driven.fact("Gaussians"), "");
  run.problem = "gpu7:6009: the training does not answer";
  driven.report(run);
  driven.report(run);
  EXPECT_EQ(driven.fact("state"), run.problem);
  EXPECT_EQ(status_line(driven.viewer).note, run.problem);
  EXPECT_EQ(driven.viewer.toasts.size(), 1u) << "a problem is said once";
}

TEST(RemoteWindow, the_address_is_no_file_that_was_opened) {
  const DrivenRemote driven;
  EXPECT_TRUE(driven.viewer.recent.empty());
}

TEST(RemoteWindow, nothing_is_measured_or_counted) {
  DrivenRemote driven;
  driven.apply(action::toggle_panel, &Panels::hud);
  EXPECT_FALSE(numbers_are_missing(driven.viewer));
  EXPECT_FALSE(counts_are_missing(driven.viewer));
}

TEST(RemoteWindow, keys_that_need_the_scene_say_so) {
  for (const char* key : {"2", "H", "Shift+H", "J", "Shift+J", "F9", "C", "X"}) {
    DrivenRemote driven;
    const CullMode mode = driven.viewer.mode();
    driven.press(key);
    ASSERT_EQ(driven.viewer.toasts.size(), 1u) << key;
    EXPECT_THAT(driven.viewer.toasts[0].text, HasSubstr("has pictures only")) << key;
    EXPECT_EQ(driven.viewer.mode(), mode);
    EXPECT_FALSE(driven.viewer.heatmap);
    EXPECT_FALSE(driven.viewer.panels.split);
    EXPECT_TRUE(driven.jobs.empty());
  }
}

TEST(RemoteWindow, a_screenshot_is_the_picture_of_the_training) {
  DrivenRemote driven;
  driven.press("Ctrl+F12");
  EXPECT_TRUE(driven.jobs.empty());
  ASSERT_EQ(driven.pictures.size(), 1u);
  EXPECT_THAT(driven.pictures[0].filename().string(), EndsWith("_0001.png"));
  EXPECT_THAT(driven.pictures[0].string(), HasSubstr("screenshots/gpu7"));
}

TEST(RemoteWindow, shows_pauses_and_resumes_a_training) {
  if (!test::display().runs()) GTEST_SKIP() << "Xvfb is not installed";
  if (test::run_program("python3", {"--version"}).exit_code == 127)
    GTEST_SKIP() << "python3 is not installed";
  const TemporaryFolder folder;
  const auto path = [&](const std::string& name) { return (folder / name).string(); };
  std::ofstream(folder / "script")
      << "wait\nkey Shift+T\nwait\nkey Ctrl+F12\nstate " << path("shown.json")
      << "\ndrag 20 10 left\nkey Shift+T\nwait\nstate " << path("moved.json") << "\nquit\n";
  const auto peer = test::run_program(
      "python3",
      {test::source_path("tests/support/network_gui_peer.py").string(), "trainer_first",
       path("port"), path("log")},
      [&](pid_t pid) {
        for (int i = 0; i < 6000 && !std::filesystem::exists(folder / "port"); ++i)
          std::this_thread::sleep_for(std::chrono::milliseconds(10));
        const auto run = test::run_quadsplat({"view", "--connect",
                                              "127.0.0.1:" + test::content_of(folder / "port"),
                                              "--settings", "-", "--size", "640x480", "--out-dir",
                                              folder.path().string(), "--input", path("script")});
        EXPECT_EQ(run.exit_code, 0) << run.err;
        ::kill(pid, SIGTERM);
      });
  const auto state = nlohmann::json::parse(test::content_of(folder / "shown.json"));
  EXPECT_EQ(state["remote"]["its data"], "/data/garden");
  EXPECT_EQ(state["remote"]["Gaussians"], "1,234");
  EXPECT_EQ(state["remote"]["loss"], "0.2500");
  EXPECT_EQ(state["remote"]["state"], "paused");
  std::vector<std::filesystem::path> saved;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "screenshots"))
    saved.push_back(entry.path());
  ASSERT_EQ(saved.size(), 1u);
  const Image picture = read_image(saved[0]);
  EXPECT_GT(picture.width, 100);
  for (int c = 0; c < 3; ++c)  // the trainer's pictures have one colour
    EXPECT_EQ(picture.at(0, 0, c), picture.at(picture.width - 1, picture.height - 1, c));
  const auto moved = nlohmann::json::parse(test::content_of(folder / "moved.json"));
  EXPECT_EQ(moved["remote"]["state"], "running");
  EXPECT_NE(moved["camera"], state["camera"]);
  const auto log = nlohmann::json::parse(test::content_of(folder / "log"));
  EXPECT_GE(log["requests"], 2);
  EXPECT_EQ(log["broken"], 0);
}

TEST(RemoteWindow, what_does_not_fit_is_refused) {
  const auto refusal = [](std::vector<std::string> words) {
    words.insert(words.begin(), "view");
    const auto run = test::run_quadsplat(words);
    EXPECT_EQ(run.exit_code, 1);
    return run.err;
  };
  EXPECT_THAT(refusal({"scene.ply", "--connect", "localhost:6009"}), HasSubstr("leave out SCENE"));
  EXPECT_THAT(refusal({"--connect", "localhost:6009", "--beside", "3dgs"}),
              HasSubstr("leave out --beside"));
  EXPECT_THAT(refusal({"--connect", "localhost"}),
              HasSubstr("view: --connect localhost: not a host and a port"));
}

}  // namespace
}  // namespace qs
