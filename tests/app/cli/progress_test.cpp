// SPDX-License-Identifier: MIT
//
// Every command that may take longer than two seconds shows its progress and the time left on a
// terminal, and leaves the line empty. Every reading of the bars' clock is a second later, so that
// short work shows its bars.
#include <atomic>
#include <chrono>
#include <filesystem>
#include <regex>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/terminal.h"
#include "app/support/transcript.h"
#include "base/progress_bar.h"
#include "io/bytes/json_text.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

using testing::HasSubstr;

// A line of a bar, without its escapes.
struct ShownBar {
  std::string label;
  int percent = 0;
  bool has_time_left = false;
};

std::vector<ShownBar> bars_in(const std::string& screen) {
  static const std::regex kBar(R"(\r([^\r\n]*) \[[# ]{32}\] +(\d+) %(, [\d:]+ left)?)");
  std::vector<ShownBar> bars;
  for (std::sregex_iterator at(screen.begin(), screen.end(), kBar), end; at != end; ++at)
    bars.push_back({(*at)[1], std::stoi((*at)[2]), (*at)[3].matched});
  return bars;
}

class CommandProgress : public testing::Test {
 protected:
  CommandProgress() {
    ProgressBar::usual_clock() = [this] { return now_ += std::chrono::seconds(1); };
  }
  ~CommandProgress() override { ProgressBar::usual_clock() = ProgressBar::Clock::now; }

  // The text on the terminal.
  std::string screen_of(const std::string& command_line) {
    std::string screen;
    std::atomic<bool> ended = false;
    const test::Terminal terminal;
    std::thread reader([&] {  // a terminal's buffer is small
      while (!ended) {
        screen += terminal.shown();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
    log_.run(command_line, test::Transcript::Errors::shown);
    ended = true;
    reader.join();
    for (std::string rest; !(rest = terminal.shown()).empty();) screen += rest;
    return screen;
  }

  // The command shows bars with these labels (or beginnings of labels), each with the time left and
  // never going backwards, and erases the last line.
  void expect_bars(const std::string& command_line, const std::vector<std::string>& labels) {
    SCOPED_TRACE(command_line);
    const std::string screen = screen_of(command_line);
    const std::vector<ShownBar> bars = bars_in(screen);
    for (const std::string& label : labels) {
      int last = -1;
      bool has_time_left = false;
      for (const ShownBar& bar : bars) {
        if (!bar.label.starts_with(label)) continue;
        EXPECT_GE(bar.percent, last) << label;
        last = bar.percent;
        has_time_left = has_time_left || bar.has_time_left;
      }
      EXPECT_GE(last, 0) << label << " is not shown in\n" << screen;
      EXPECT_TRUE(has_time_left) << label;
    }
    const std::size_t end = screen.rfind("\r");
    ASSERT_NE(end, std::string::npos);
    const std::size_t erased = screen.rfind("\r\033[K"), shown = screen.rfind(" %");
    EXPECT_TRUE(erased != std::string::npos && erased > shown) << "the line is not erased";
  }

  test::Transcript log_;
  ProgressBar::Clock::time_point now_{};
};

TEST_F(CommandProgress, is_erased_at_0_percent_too_and_only_if_it_is_shown) {
  const test::Terminal terminal;
  ProgressBar bar("working");
  bar.hide();
  EXPECT_EQ(terminal.shown(), "");
  bar.progress().report(0);
  EXPECT_THAT(terminal.shown(), HasSubstr("working ["));
  bar.hide();
  EXPECT_EQ(terminal.shown(), "\r\033[K");
}

TEST_F(CommandProgress, is_shown_by_the_commands_that_draw) {
  expect_bars("render scene.ply --all-cameras --output all.ppm", {"rendering"});
  expect_bars("render scene.ply --cull all --psnr --repeats 2", {"rendering"});
  expect_bars("film scene.ply --seconds 0.2 --size 16x16 --output frames", {"filming"});
  expect_bars("film scene.ply --seconds 0.2 --size 16x16 --heatmap pairs --output heat",
              {"choosing the scale", "filming"});
  expect_bars("compare scene.ply --cull 3dgs,exact", {"comparing"});
}

TEST_F(CommandProgress, is_shown_by_the_commands_that_measure) {
  expect_bars("bench scene.ply --cull adr,exact --frames 1 --warmup 0", {"scene (1/1)"});
  expect_bars("bench scene.ply --load --rounds 1", {"reading"});
  expect_bars(
      "zoom scene.ply --target 0,0,3 --steps 3 --frames 1 --warmup 0 --cull adr --out-dir z",
      {"zoom scene"});
  expect_bars("zoom --replay z", {"zoom scene"});
  expect_bars("report scene.ply --views 2 --output page.html", {"studying", "drawing heat maps"});
}

TEST_F(CommandProgress, is_shown_by_the_commands_that_compare_pictures) {
  expect_bars("judge images images", {"judging"});
  expect_bars("compare scene.ply alone/deep/er/folder/scene.ply", {"judging"});
  expect_bars("eval scene.ply --images images", {"evaluating"});
}

TEST_F(CommandProgress, is_shown_by_the_conformance_kit) {
  expect_bars("conformance --out-dir kit", {"drawing the scenes"});
  std::filesystem::create_directories("wrong");
  write_image(Image(64, 64, 3), "wrong/one-gaussian.png");
  expect_bars("conformance --judge wrong", {"drawing with mistakes"});
}

TEST_F(CommandProgress, is_shown_by_the_commands_that_read_and_write_scenes) {
  expect_bars("info scene.ply", {"reading"});
  expect_bars("inspect scene.ply", {"reading"});
  expect_bars("convert scene.ply out.spz --drop-floaters",
              {"reading", "looking for floaters", "writing"});
}

TEST_F(CommandProgress, is_shown_by_training) {
  expect_bars("train . --random-points 50 --iterations 3 --holdout 2 --out-dir model",
              {"reading photographs", "loss ", "evaluating"});
}

}  // namespace
}  // namespace qs
