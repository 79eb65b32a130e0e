// SPDX-License-Identifier: MIT
//
// One session in the window, as a user has it: open, fly, switch through all modes, a heat map, the
// grid of all modes, a recorded zoom. Other commands draw and count the same views, and every
// number of the window is compared with theirs.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/program_in_window.h"
#include "base/text.h"
#include "raster/kernel/cull/mode.h"
#include "support/paths.h"

namespace qs {
namespace {

using nlohmann::json;
using test::ProgramRun;
using test::run_quadsplat;
using testing::HasSubstr;

std::uint64_t number_of(std::string text) {
  std::erase(text, ',');
  std::uint64_t number = 0;
  std::istringstream(text) >> number;
  return number;
}

class ViewerSession : public test::ProgramInWindow {
 protected:
  const std::string scene_ = test::source_path("assets/plush.ply").string();

  // The frames of all modes of the window's camera, from a command without a window.
  json rendered(const json& shown, const std::string& size) {
    const ProgramRun run =
        run_quadsplat({"render", scene_, "--backend", "cpu", "--camera-json",
                       shown["camera"].dump(), "--cull", "all", "--size", size, "--stats", "-"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(run.out)["frames"];
  }
  static std::string size_of_picture(const json& shown) {
    return fmt::format("{}x{}", shown["camera"]["width"].get<int>(),
                       shown["camera"]["height"].get<int>());
  }
  static std::string measured_size(const json& shown) {
    return fmt::format("{}x{}", shown["measured_size"][0].get<int>(),
                       shown["measured_size"][1].get<int>());
  }

  // Each row of the table has the pairs and the visible Gaussians of a frame that was drawn alone.
  void expect_counts_of_frames(const json& shown) {
    const json frames = rendered(shown, measured_size(shown));
    ASSERT_EQ(frames.size(), shown["modes"].size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const json& row = shown["modes"][i];
      const auto pairs = frames[i]["tile_pairs"].get<std::uint64_t>();
      EXPECT_EQ(number_of(row["pairs"]), pairs) << row;
      EXPECT_EQ(row["live_pairs"], pairs) << row;
      const double per_visible = static_cast<double>(pairs) / frames[i]["visible"].get<double>();
      EXPECT_EQ(row["per_visible"], fmt::format("{:.2f}", per_visible)) << row;
    }
  }
};

TEST_F(ViewerSession, shows_numbers_that_other_commands_confirm) {
  std::string script = "key F10\nwait\nstate " + path("opened") + "\npress W\nsleep 0.6\nstate " +
                       path("flying") + "\nrelease W\nwait\nstate " + path("arrived") + "\n";
  for (CullMode mode = 1; mode <= culler_count(); ++mode)
    script += fmt::format("key {0}\nwait\nstate {1}{0}\n", mode, path("mode"));
  script += "key H\nwait\nstate " + path("map") + "\nkey 1\nwait\nstate " + path("map_3dgs") +
            "\nkey H\nkey F9\nwait\nstate " + path("grid") + "\nkey F9\nwait\n";
  script +=
      "zoom steps=12 frames=20 closer=16 modes=3dgs,quadbox\nkey Z\nwait\nkey Shift+Z\nsleep "
      "0.1\nwait\nstate " +
      path("zoomed") + "\nquit\n";
  const ProgramRun run = play(script, {scene_, "--size", "360x240"});
  ASSERT_EQ(run.exit_code, 0) << run.err;

  // Flying: every mode has counts of this view or of a recent one, and the mode in use has FPS.
  const json opened = state("opened"), flying = state("flying"), arrived = state("arrived");
  EXPECT_NE(opened["camera"]["position"], arrived["camera"]["position"]);
  EXPECT_FALSE(flying["numbers_are_current"]);
  for (const json& row : flying["modes"]) {
    EXPECT_TRUE(row["live_pairs"].is_number()) << row;
    EXPECT_LE(row["live_frames_ago"].get<int>(), 10) << row;
    if (row["mode"] == flying["mode"]) {
      EXPECT_THAT(row["fps"].get<std::string>(), HasSubstr("~"));
    }
  }
  expect_counts_of_frames(opened);
  expect_counts_of_frames(arrived);

  // Toggling: the status line and the facts have the numbers of the mode's row, at its size.
  const json frames = rendered(state("mode1"), measured_size(state("mode1")));
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const json shown = state("mode" + std::to_string(mode));
    const json& row = shown["modes"][static_cast<std::size_t>(mode - 1)];
    EXPECT_EQ(shown["mode"], mode_name(mode));
    EXPECT_EQ(shown["camera"], arrived["camera"]);
    EXPECT_TRUE(shown["numbers_are_current"]);
    const std::string line = shown["line"];
    EXPECT_THAT(line, HasSubstr(fmt::format("{} ms, {} FPS", row["ms"].get<std::string>(),
                                            row["fps"].get<std::string>())));
    EXPECT_EQ(number_of(shown["facts"]["tile pairs"]),
              frames[static_cast<std::size_t>(mode - 1)]["tile_pairs"].get<std::uint64_t>());
    EXPECT_THAT(line, HasSubstr(shown["facts"]["tile pairs"].get<std::string>() + " pairs"));
  }

  // Heat maps: the total of each mode, by one scale.
  const json map = state("map"), map_3dgs = state("map_3dgs");
  const json frames_of_maps = rendered(map, size_of_picture(map));
  const auto pairs_of = [&](const std::string& mode) {
    return frames_of_maps[static_cast<std::size_t>(find_culler(mode) - 1)]["tile_pairs"];
  };
  EXPECT_EQ(map["camera"], map_3dgs["camera"]);
  EXPECT_EQ(map["heatmap"]["total"], pairs_of(map["mode"]));
  EXPECT_EQ(map_3dgs["heatmap"]["total"], pairs_of("3dgs"));
  EXPECT_LT(map["heatmap"]["total"], map_3dgs["heatmap"]["total"]);
  EXPECT_EQ(map["heatmap"]["max"], map_3dgs["heatmap"]["max"]);

  // The grid: the FPS, pairs and ratio of each mode are the numbers of the table.
  const json grid = state("grid");
  for (std::size_t i = 0; i < grid["grid"].size(); ++i) {
    const json& row = grid["modes"][i];
    EXPECT_EQ(grid["grid"][i]["mode"], row["mode"]);
    EXPECT_EQ(grid["grid"][i]["label"],
              fmt::format("{} FPS \u00b7 {} pairs \u00b7 {}", row["fps"].get<std::string>(),
                          row["pairs"].get<std::string>(), row["ratio"].get<std::string>()));
  }

  // The zoom: the chart has the medians of the CSV, and another program counts the same pairs.
  const json zoom = state("zoomed")["zoom"];
  const std::filesystem::path folder = zoom["folder"].get<std::string>();
  const std::size_t rows = 2 * 12;  // modes and steps
  EXPECT_EQ(zoom["frames"], 20);
  EXPECT_EQ(zoom["rows"], rows);
  std::vector<std::string> lines = separated(read_text_file(folder / "zoom.csv", 1 << 24), '\n');
  ASSERT_EQ(lines.back(), "") << "the file ends with a line break";
  lines.pop_back();
  ASSERT_EQ(lines.size(), 1 + rows);
  const std::vector<std::string> names = separated(lines[0], ',');
  std::map<std::string, std::vector<double>> fps;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> cells = separated(lines[i], ',');
    const auto cell = [&](const char* name) {
      return cells[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) -
                                            names.begin())];
    };
    EXPECT_EQ(cell("frames"), "20");
    fps[cell("mode")].push_back(std::stod(cell("fps_median")));
  }
  for (const json& curve : zoom["chart"]["curves"]) {
    const std::vector<double>& medians = fps[curve["mode"]];
    ASSERT_EQ(curve["points"].size(), medians.size());
    for (std::size_t step = 0; step < medians.size(); ++step)
      EXPECT_NEAR(curve["points"][step][1].get<double>(), medians[step],
                  1e-4 * medians[step] + 1e-3);
  }
  // --replay ends with an error if a count differs.
  EXPECT_EQ(run_quadsplat({"zoom", "--replay", folder.string(), "--backend", "cpu"}).exit_code, 0);
}

}  // namespace
}  // namespace qs
