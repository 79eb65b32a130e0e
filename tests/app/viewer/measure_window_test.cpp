// SPDX-License-Identifier: MIT
//
// Measuring and selecting in the real program in a real window, by the mouse and by the keyboard.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/program_in_window.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

using nlohmann::json;
using test::ProgramRun;
using test::run_quadsplat;
using testing::HasSubstr;

using MeasureProgram = test::ProgramInWindow;

TEST_F(MeasureProgram, points_of_the_window_are_the_points_of_the_command) {
  const ProgramRun run =
      play("wait\nkey Tab\nwait\nshot " + path("before.png") +
               "\nkey Shift+M\nmove 160 120\nclick\nwait\nmove 130 110\nclick\nwait\n"
               "key Right\nkey Shift+Down\nkey Enter\nwait\nsleep 0.5\nwait\nstate " +
               path("a.json") + "\nshot " + path("after.png") + "\nkey Ctrl+Z\nwait\nstate " +
               path("b.json") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const ProgramRun command = run_quadsplat({"measure", path("scene.ply"), "--backend", "cpu",
                                            "--camera-index", "0", "--size", "320x240", "--pixels",
                                            "160,120", "130,110", "161,130", "--json", "-"});
  ASSERT_EQ(command.exit_code, 0) << command.err;
  const json a = state("a.json"), expected = parse_json(command.out, "test");
  ASSERT_EQ(a["measures"].size(), 3u + 2 + 1 + 1);
  for (std::size_t i = 0; i < 3; ++i) {
    const json& at = expected["points"][i]["position"];
    EXPECT_EQ(a["measures"][i][1], fmt::format("({:.6g}, {:.6g}, {:.6g})", at[0].get<double>(),
                                               at[1].get<double>(), at[2].get<double>()));
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const json& leg = expected["distances"][i];
    EXPECT_EQ(a["measures"][3 + i][1],
              fmt::format("{:.5g} ± {:.2g} units", leg["length"].get<double>(),
                          leg["error"].get<double>()));
    EXPECT_EQ(a["rulers"][i]["known"], true);
  }
  EXPECT_EQ(state("b.json")["measures"].size(), 3u) << "two points and their distance";
  EXPECT_NE(read_image(path("after.png")).values, read_image(path("before.png")).values);
}

TEST_F(MeasureProgram, the_keyboard_alone_selects_hides_and_takes_back) {
  const ProgramRun run = play(
      "wait\nkey Shift+B\nkey Shift+Left\nkey Shift+Up\nkey Enter\nkey Shift+Right\nkey "
      "Shift+Right\nkey Shift+Down\nkey Shift+Down\nkey Enter\nwait\nstate " +
          path("selected.json") + "\nkey Ctrl+H\nwait\nstate " + path("hidden.json") +
          "\nkey Ctrl+Z\nwait\nkey Shift+Delete\nwait\nstate " + path("only.json") +
          "\nkey Ctrl+Z\nkey Ctrl+Z\nkey Ctrl+Z\nwait\nstate " + path("whole.json") + "\nquit\n",
      {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto whole = state("whole.json")["gaussians"].get<std::size_t>();
  const auto count = state("selected.json")["crop"]["selected"].get<std::size_t>();
  EXPECT_EQ(whole, 401u);
  EXPECT_GT(count, 0u);
  EXPECT_EQ(state("hidden.json")["gaussians"], whole - count);
  EXPECT_EQ(state("only.json")["gaussians"], count);
  EXPECT_FALSE(state("whole.json").contains("crop"));
}

}  // namespace
}  // namespace qs
