// SPDX-License-Identifier: MIT
//
// The real program in a real window: Xvfb, software OpenGL, the CPU backend, scripted input.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/support/program_in_window.h"
#include "app/support/run_program.h"
#include "app/support/virtual_display.h"
#include "app/viewer/window/input_script.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/cloud/axes.h"
#include "io/picture/image_file.h"
#include "io/scene/writer.h"
#include "raster/kernel/cull/mode.h"
#include "support/built_scenes.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using nlohmann::json;
using test::ProgramRun;
using test::run_quadsplat;
using testing::HasSubstr;
using testing::StartsWith;

class ViewerProgram : public test::ProgramInWindow {
 protected:
  // The false positives of `bench` for camera 0 in mode quadbox at this size.
  std::uint64_t benched_false_positives(int width, int height) {
    const ProgramRun run =
        run_quadsplat({"bench", path("scene.ply"), "--backend", "cpu", "--camera-index", "0",
                       "--size", fmt::format("{}x{}", width, height), "--cull", "quadbox",
                       "--frames", "1", "--warmup", "0", "--out-dir", path("bench")});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const json bench = parse_json(read_text_file(folder_ / "bench/bench.json", 1 << 20), "test");
    return bench.at("rows").at(0).at("false_positives");
  }
};

TEST_F(ViewerProgram, opens_the_scene_of_the_command_line_and_measures_all_modes) {
  const ProgramRun run =
      play("key F10\nwait\nstate " + path("a.json") + "\nquit\n", {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json a = state("a.json");
  EXPECT_EQ(a["scene"], "scene");
  EXPECT_EQ(a["dataset_camera"], 0);
  EXPECT_EQ(a["modes"].size(), static_cast<std::size_t>(culler_count()));
  for (const json& row : a["modes"]) EXPECT_NE(row["ms"], "-") << row;
  EXPECT_TRUE(a["numbers_are_current"]);
  EXPECT_GE(a["frames_behind"].get<int>(), 5);
  EXPECT_THAT(a["status"].get<std::string>(), HasSubstr("medians of "));
}

TEST_F(ViewerProgram, counts_the_pairs_of_all_modes_while_it_flies_and_as_the_measurement_does) {
  const ProgramRun run =
      play("key F10\nwait\nstate " + path("a.json") + "\npress W\nsleep 0.5\nstate " +
               path("flying.json") + "\nrelease W\nwait\nstate " + path("b.json") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json a = state("a.json"), flying = state("flying.json"), b = state("b.json");
  EXPECT_NE(a["modes"][0]["live_pairs"], b["modes"][0]["live_pairs"]);
  EXPECT_FALSE(flying["numbers_are_current"]);
  for (const json& row : flying["modes"]) EXPECT_TRUE(row["live_pairs"].is_number()) << row;
  for (const json* shown : {&a, &b}) {
    for (const json& row : (*shown)["modes"]) {
      std::string measured = row["pairs"];
      std::erase(measured, ',');
      EXPECT_EQ(std::to_string(row["live_pairs"].get<std::uint64_t>()), measured) << row;
      EXPECT_EQ(row["live_frames_ago"], 0);
    }
  }
}

TEST_F(ViewerProgram, compares_the_view_with_its_photograph_as_eval_does) {
  // Photographs of half of the cameras' size, drawn in another mode.
  std::vector<Camera> cameras = read_cameras(folder_ / "cameras.json");
  cameras[0].name = "first.png";
  cameras[1].name = "second.png";
  test::write_cameras(cameras, folder_ / "cameras.json");
  std::filesystem::create_directory(folder_ / "images");
  for (const char* camera : {"0", "1"}) {
    const std::string file = camera[0] == '0' ? "first.png" : "second.png";
    const ProgramRun run = run_quadsplat(
        {"render", path("scene.ply"), "--backend", "cpu", "--cull", "3dgs", "--camera-index",
         camera, "--size", "160x120", "--splat-scale", "0.8", "--output", path("images/" + file)});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  const ProgramRun run =
      play("wait\nkey G\nwait\nstate " + path("first") + "\nkey ]\nwait\nstate " + path("second") +
               "\ndrag 5 5 left\nwait\nstate " + path("moved") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const ProgramRun eval = run_quadsplat(
      {"eval", path("scene.ply"), "--backend", "cpu", "--images", path("images"), "--json", "-"});
  ASSERT_EQ(eval.exit_code, 0) << eval.err;
  const json views = json::parse(eval.out)["views"];
  ASSERT_EQ(views.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const char* const name = i == 0 ? "first" : "second";
    EXPECT_EQ(state(name)["photograph"],
              fmt::format("photograph {}.png \u00b7 PSNR {:.2f} dB, SSIM {:.3f}", name,
                          views[i]["psnr"].get<double>(), views[i]["ssim"].get<double>()));
  }
  EXPECT_EQ(state("moved")["photograph"], "photograph second.png");
}

TEST_F(ViewerProgram, the_first_start_opens_the_bundled_scene_and_a_later_one_welcomes) {
  const std::vector<std::string> settings = {"--settings", path("viewer.json")};
  for (const char* name : {"first", "later"}) {
    const ProgramRun run = play("sleep 0.3\nwait\nstate " + path(name) + "\nshot " +
                                    path(std::string(name) + ".png") + "\nquit\n",
                                settings);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  EXPECT_EQ(state("first")["scene"], "plush");
  EXPECT_EQ(state("first")["hints"],
            json({"W A S D: fly", fmt::format("1 to {}: modes", culler_count()), "H: heat map",
                  "Z: record the zoom"}));
  EXPECT_EQ(state("later")["scene"], "");
  EXPECT_EQ(state("later")["hints"].size(), 0u);
  // The welcome screen with the scene's picture is in the middle.
  const Image later = read_image(path("later.png"));
  int bright = 0;
  for (int y = 60; y < 180; ++y) {
    for (int x = 80; x < 240; ++x) bright += later.at(x, y, 0) > 0.4f ? 1 : 0;
  }
  EXPECT_GT(bright, 120 * 160 / 10);
}

TEST_F(ViewerProgram, opens_what_is_dropped_on_an_empty_window) {
  const ProgramRun run = play("state " + path("a.json") + "\ndrop " + path("scene.ply") +
                              "\nwait\nstate " + path("b.json") + "\nquit\n");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(state("a.json")["scene"], "");
  EXPECT_EQ(state("b.json")["scene"], "scene");
}

TEST_F(ViewerProgram, switches_all_modes_by_both_rows_of_digits) {
  std::string script = "key F10\nwait\n";
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    script += "key " + std::to_string(mode) + "\nwait\nstate " +
              path("key" + std::to_string(mode)) + "\n";
  }
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    script += "keypad " + std::to_string(mode) + "\nwait\nstate " +
              path("keypad" + std::to_string(mode)) + "\n";
  }
  const ProgramRun run = play(script + "quit\n", {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const char* name = mode_name(mode);
    const json by_key = state("key" + std::to_string(mode));
    EXPECT_EQ(by_key["mode"], name);
    EXPECT_EQ(state("keypad" + std::to_string(mode))["mode"], name);
  }
  // A render at the size that the table names has the table's pairs.
  const json last = state("key1");
  const std::string size = fmt::format("{}x{}", last["measured_size"][0].get<int>(),
                                       last["measured_size"][1].get<int>());
  const ProgramRun rendered =
      run_quadsplat({"render", path("scene.ply"), "--camera-json", last["camera"].dump(), "--cull",
                     "all", "--size", size, "--stats", "-"});
  ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
  const json frames = json::parse(rendered.out)["frames"];
  for (std::size_t i = 0; i < frames.size(); ++i) {
    std::string pairs = last["modes"][i]["pairs"];
    std::erase(pairs, ',');
    EXPECT_EQ(pairs, std::to_string(frames[i]["tile_pairs"].get<std::uint64_t>()));
  }
}

TEST_F(ViewerProgram, panels_change_neither_the_measured_size_nor_the_counts_of_the_table) {
  const ProgramRun run = play("key F10\nwait\nstate " + path("left") +
                                  "\nkey I\nkey 1\nwait\nstate " + path("both") + "\nquit\n",
                              {path("scene.ply"), "--size", "1100x240"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json left = state("left"), both = state("both");
  EXPECT_NE(left["camera"], both["camera"]) << "the second bar makes the picture narrower";
  EXPECT_EQ(left["measured_size"], both["measured_size"]);
  for (std::size_t i = 0; i < left["modes"].size(); ++i)
    EXPECT_EQ(left["modes"][i]["pairs"], both["modes"][i]["pairs"]);
  EXPECT_THAT(left["status"].get<std::string>(), HasSubstr(" at "));
  EXPECT_EQ(left.at("columns").at(1), "FPS");
}

TEST_F(ViewerProgram, heat_map_shows_its_total_and_changes_the_picture) {
  const ProgramRun run = play("key Tab\nwait\nshot " + path("off.png") + "\nkey H\nwait\nshot " +
                                  path("on.png") + "\nstate " + path("on.json") +
                                  "\nkey H\nwait\nshot " + path("again.png") + "\nquit\n",
                              {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json on = state("on.json");
  EXPECT_EQ(on["heatmap"]["quantity"], "pairs");
  std::string pairs = on["facts"]["tile pairs"];
  std::erase(pairs, ',');
  EXPECT_EQ(std::to_string(on["heatmap"]["total"].get<std::uint64_t>()), pairs);
  EXPECT_THAT(on["caveat"].get<std::string>(), HasSubstr("heat map"));
  const Image off = read_image(path("off.png")), heat = read_image(path("on.png"));
  EXPECT_LT(psnr_8bit(off, heat), 25);
  EXPECT_EQ(off.values, read_image(path("again.png")).values);
}

TEST_F(ViewerProgram, depth_has_a_legend_and_changes_the_picture) {
  const ProgramRun run =
      play("key Tab\nwait\nshot " + path("off.png") + "\nkey J\nwait\nshot " + path("on.png") +
               "\nstate " + path("on.json") + "\nkey Shift+J\nwait\nstate " + path("median.json") +
               "\nkey J\nwait\nshot " + path("again.png") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json on = state("on.json");
  EXPECT_EQ(on["picture"]["quantity"], "depth");
  EXPECT_LT(on["picture"]["low"].get<float>(), on["picture"]["high"].get<float>());
  EXPECT_EQ(state("median.json")["picture"]["quantity"], "median-depth");
  EXPECT_THAT(on["caveat"].get<std::string>(), HasSubstr("without colours"));
  const Image off = read_image(path("off.png")), depth = read_image(path("on.png"));
  EXPECT_LT(psnr_8bit(off, depth), 25);
  EXPECT_EQ(off.values, read_image(path("again.png")).values);
}

TEST_F(ViewerProgram, flying_moves_the_camera_and_home_brings_it_back) {
  const ProgramRun run =
      play("wait\nstate " + path("a.json") + "\nhold W 0.3\nwait\nstate " + path("b.json") +
               "\nkey Home\nwait\nstate " + path("c.json") +
               "\ndrag 40 10 left\nwheel 2\nwait\nstate " + path("d.json") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_GT(state("b.json")["camera"]["position"][2].get<double>(), 0.01);
  EXPECT_EQ(state("b.json")["dataset_camera"], -1);
  EXPECT_EQ(state("c.json")["camera"], state("a.json")["camera"]);
  EXPECT_NE(state("d.json")["camera"], state("a.json")["camera"]);
}

TEST_F(ViewerProgram, the_window_and_the_screenshot_equal_a_headless_render) {
  const ProgramRun run = play("wait\nkey Tab\nkey ]\nwait\nshot " + path("window.png") +
                                  "\nkey Ctrl+F12\nwait\nstate " + path("a.json") + "\nquit\n",
                              {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const ProgramRun render =
      run_quadsplat({"render", path("scene.ply"), "--backend", "cpu", "--camera-index", "1",
                     "--size", "320x240", "--output", path("render.png")});
  ASSERT_EQ(render.exit_code, 0) << render.err;
  const std::string screenshot = path("screenshots/scene_camera1_quadbox_320x240_0001.png");
  EXPECT_EQ(read_text_file(screenshot, 1 << 24), read_text_file(path("render.png"), 1 << 24));
  // The window shows the same bytes, apart from the sentence that the file was written.
  EXPECT_EQ(read_image(path("window.png")).values, read_image(path("render.png")).values);
}

TEST_F(ViewerProgram, a_bad_file_keeps_the_scene_and_shows_the_sentence) {
  std::ofstream(folder_ / "broken.ply") << "ply\nnonsense";
  const ProgramRun run =
      play("wait\ndrop " + path("broken.ply") + "\nwait\nstate " + path("a.json") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json a = state("a.json");
  EXPECT_EQ(a["scene"], "scene");
  ASSERT_EQ(a["toasts"].size(), 1u);
  EXPECT_THAT(a["toasts"][0].get<std::string>(), HasSubstr("broken.ply"));
}

TEST_F(ViewerProgram, cameras_are_dropped_copied_and_pasted) {
  std::filesystem::rename(folder_ / "cameras.json", folder_ / "other.json");
  Camera pasted = test::front_camera(320, 240);
  pasted.view_from_world[3].z = 0.5;
  const ProgramRun run =
      play("key Tab\nwait\nstate " + path("a.json") + "\ndrop " + path("other.json") +
               "\nwait\nstate " + path("b.json") + "\npaste " + format_camera(pasted) +
               "\nkey Ctrl+V\nwait\nstate " + path("c.json") +
               "\npaste nonsense\nkey Ctrl+V\nwait\nstate " + path("d.json") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(state("a.json")["dataset_camera"], -1);
  EXPECT_EQ(state("b.json")["dataset_camera"], 0);
  EXPECT_EQ(state("c.json")["camera"], parse_json(format_camera(pasted), "test"));
  EXPECT_EQ(state("d.json")["camera"], state("c.json")["camera"]);
  EXPECT_THAT(state("d.json")["toasts"].back().get<std::string>(), HasSubstr("clipboard"));
}

// The cells of a CSV file, line by line, with the head.
std::vector<std::vector<std::string>> cells_of(const std::filesystem::path& path) {
  std::ifstream csv(path);
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(csv, line);) {
    std::istringstream words(line);
    rows.emplace_back();
    for (std::string cell; std::getline(words, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

TEST_F(ViewerProgram, a_recorded_zoom_has_the_numbers_of_its_csv_and_replays_with_equal_counts) {
  const ProgramRun run = play("wait\nzoom steps=3 closer=4\nkey Z\nwait\nstate " +
                                  path("before.json") + "\nkey Shift+Z\nsleep 0.1\nwait\nstate " +
                                  path("a.json") + "\nshot " + path("zoom.png") + "\nquit\n",
                              {path("scene.ply"), "--size", "640x400"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(state("before.json")["zoom"]["rows"], 0);
  const json zoom = state("a.json")["zoom"];
  const std::string folder = zoom["folder"];
  ASSERT_THAT(folder, StartsWith(path("zoom")));
  EXPECT_EQ(zoom["frames"], 20);
  EXPECT_EQ(zoom["rows"], 3 * culler_count());
  EXPECT_EQ(zoom["chart"]["zoom_ticks"], json({"1x", "2x"}));
  const auto rows = cells_of(std::filesystem::path(folder) / "zoom.csv");
  ASSERT_EQ(rows.size(), 1u + static_cast<std::size_t>(3 * culler_count()));
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::find(rows[0].begin(), rows[0].end(), name) -
                                    rows[0].begin());
  };
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const std::size_t step = (i - 1) / static_cast<std::size_t>(culler_count());
    const json& curve = zoom["chart"]["curves"][(i - 1) % static_cast<std::size_t>(culler_count())];
    EXPECT_EQ(rows[i][column("mode")], curve["mode"].get<std::string>());
    EXPECT_EQ(rows[i][column("frames")], "20");
    EXPECT_TRUE(curve["bars"].get<bool>());
    EXPECT_NEAR(curve["points"][step][0].get<double>(), std::pow(2, step), 1e-9);
    const double fps = std::stod(rows[i][column("fps_median")]);
    EXPECT_NEAR(curve["points"][step][1].get<double>(), fps, 1e-4 * fps + 1e-3);
  }
  EXPECT_EQ(run_quadsplat({"zoom", "--replay", folder, "--backend", "cpu"}).exit_code, 0);
}

TEST_F(ViewerProgram, a_wrong_word_of_a_script_s_zoom_is_shown_and_changes_nothing) {
  const ProgramRun run = play("wait\nzoom steps=1\nstate " + path("a.json") +
                                  "\nzoom speed=3\nstate " + path("b.json") + "\nquit\n",
                              {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(state("a.json")["zoom"]["plan"]["steps"], 12);
  EXPECT_THAT(state("a.json")["toasts"].back().get<std::string>(), HasSubstr("zoom: steps"));
  EXPECT_THAT(state("b.json")["toasts"].back().get<std::string>(), HasSubstr("'speed'"));
}

TEST_F(ViewerProgram, a_bench_s_csv_holds_the_numbers_of_the_display) {
  const ProgramRun run =
      play("wait\nkey P\nwait\nstate " + path("a.json") + "\nquit\n", {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::ifstream csv(folder_ / "bench/scene_0001/bench.csv");
  std::string line;
  std::getline(csv, line);
  const json a = state("a.json");
  for (const json& row : a["modes"]) {
    ASSERT_TRUE(std::getline(csv, line));
    std::vector<std::string> cells;
    std::istringstream words(line);
    for (std::string cell; std::getline(words, cell, ',');) cells.push_back(cell);
    EXPECT_EQ(cells[2], row["mode"].get<std::string>());
    std::string pairs = row["pairs"];
    std::erase(pairs, ',');
    EXPECT_EQ(cells[9], pairs);
    EXPECT_NEAR(std::stod(cells[12]), row["ms_median"].get<double>(), 5.1e-5);
  }
}

TEST_F(ViewerProgram, the_inspector_says_what_the_command_says) {
  const ProgramRun run = play("wait\nkey Tab\nkey B\nsleep 0.2\nmove 40 120\nclick\nwait\nstate " +
                                  path("a.json") + "\nshot " + path("inspector.png") + "\nquit\n",
                              {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const ProgramRun inspect =
      run_quadsplat({"inspect", path("scene.ply"), "--backend", "cpu", "--camera-index", "0",
                     "--size", "320x240", "--pixel", "40,120", "--json", "-"});
  ASSERT_EQ(inspect.exit_code, 0) << inspect.err;
  const json headless = parse_json(inspect.out, "test");
  const json window = state("a.json")["inspector"];
  ASSERT_TRUE(window.is_object());
  for (const auto& [key, value] : window.items()) EXPECT_EQ(headless[key], value) << key;
}

TEST_F(ViewerProgram, the_reference_finds_the_frame_equal_and_a_lossy_mode_not) {
  const ProgramRun run =
      play("wait\nkey 0\nwait\nstate " + path("a.json") + "\nkey 3\nwait\nkey 0\nwait\nstate " +
               path("b.json") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(state("a.json")["oracle"].get<std::string>(),
              StartsWith("quadbox: equal to the reference within 2/255"));
  EXPECT_THAT(state("b.json")["oracle"].get<std::string>(), HasSubstr("pixel"));
}

TEST_F(ViewerProgram, the_split_window_shows_both_variants_and_tells_how_they_differ) {
  const ProgramRun run = play(
      "key F10\nkey 3\nwait\nkey Tab\nwait\nshot " + path("first.png") + "\nkey 1\nwait\nshot " +
          path("other.png") + "\nkey 3\nkey C\nwait\nstate " + path("sides.json") +
          "\nmove 160 200\nsleep 0.1\ndrag -80 0 left\nwait\nstate " + path("dragged.json") +
          "\nshot " + path("dragged.png") + "\nkey X\nwait\nshot " + path("flipped.png") +
          "\nkey Shift+C\nwait\nstate " + path("whole.json") + "\nshot " + path("whole.png") +
          "\nkey Shift+C\nwait\nshot " + path("difference.png") + "\nstate " +
          path("difference.json") + "\nkey Shift+C\nwait\nshot " + path("pairs.png") +
          "\nkey C\nwait\nstate " + path("off.json") + "\nshot " + path("off.png") + "\nquit\n",
      {path("scene.ply"), "--cull", "3dgs"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json sides = state("sides.json"), dragged = state("dragged.json");
  EXPECT_EQ(sides["split"]["first"], "dualbox, cpu");
  EXPECT_EQ(sides["split"]["other"], "3dgs, cpu");
  EXPECT_EQ(sides["split"]["divider"], 0.5);
  EXPECT_THAT(sides["caveat"].get<std::string>(), HasSubstr("split window"));
  EXPECT_NEAR(dragged["split"]["divider"].get<double>(), 0.25, 0.01);
  EXPECT_EQ(dragged["camera"], sides["camera"]);
  EXPECT_EQ(state("whole.json")["split"]["view"], "one at a time");
  EXPECT_FALSE(state("off.json").contains("split"));

  const Image first = read_image(path("first.png")), other = read_image(path("other.png"));
  EXPECT_EQ(sides["split"]["PSNR"], decibels(psnr_8bit(first, other)) + " dB");
  EXPECT_EQ(read_image(path("off.png")).values, first.values);
  const Image split = read_image(path("dragged.png")), flipped = read_image(path("flipped.png"));
  const Image whole = read_image(path("whole.png"));
  const Image difference = read_image(path("difference.png"));
  // The factor: at most one in fifty of the pixels that differ is clipped.
  std::vector<int> sizes;
  for (int y = 0; y < first.height; ++y) {
    for (int x = 0; x < first.width; ++x) {
      int largest = 0;
      for (int c = 0; c < 3; ++c)
        largest =
            std::max(largest, std::abs(to_8bit(first.at(x, y, c)) - to_8bit(other.at(x, y, c))));
      if (largest > 0) sizes.push_back(largest);
    }
  }
  ASSERT_FALSE(sizes.empty());
  const auto clipped = [&](int factor) {
    return std::count_if(sizes.begin(), sizes.end(), [=](int d) { return d * factor > 255; });
  };
  const auto most = static_cast<std::ptrdiff_t>(sizes.size() / 50);
  const int factor = state("difference.json")["split"]["amplification"];
  EXPECT_LE(clipped(factor), most);
  EXPECT_TRUE(factor == 128 || clipped(2 * factor) > most) << factor;
  // Rows that neither names nor the grip of the divider cover.
  for (int y = 40; y < 100; ++y) {
    for (const int x : {10, 60, 100, 200, 300}) {
      for (int c = 0; c < 3; ++c) {
        const bool left = x < 80;
        const float a = first.at(x, y, c), b = other.at(x, y, c);
        EXPECT_EQ(split.at(x, y, c), left ? a : b);
        EXPECT_EQ(flipped.at(x, y, c), left ? b : a);
        EXPECT_EQ(whole.at(x, y, c), b);
        EXPECT_NEAR(difference.at(x, y, c),
                    std::min(1.0f, static_cast<float>(factor) * std::abs(a - b)), 1.01 / 255);
      }
    }
  }
  EXPECT_LT(psnr_8bit(read_image(path("pairs.png")), first), 25);
}

TEST_F(ViewerProgram, another_scene_is_beside_the_first_from_the_same_camera) {
  std::filesystem::create_directory(folder_ / "two");  // without cameras
  GaussianCloud cloud = test::random_cloud(300, 1, 8);
  test::append(cloud, test::single_gaussian({0, 0, 4}, 0.5f, {0.1f, 0.4f, 0.9f}, 5));
  test::write_scene(cloud, path("two/other.ply"));
  const ProgramRun alone = play("key Tab\nwait\nshot " + path("second.png") + "\nquit\n",
                                {path("two/other.ply"), "--cameras", path("cameras.json")});
  ASSERT_EQ(alone.exit_code, 0) << alone.err;
  const ProgramRun run =
      play("key Tab\nwait\nstate " + path("sides.json") + "\nshot " + path("sides.png") +
               "\nmove 160 200\nsleep 0.1\ndrag -80 0 left\nwait\nshot " + path("dragged.png") +
               "\nkey X\nwait\nstate " + path("flipped.json") + "\nshot " + path("flipped.png") +
               "\nkey X\nkey ]\nkey 6\nwait\nstate " + path("moved.json") +
               "\nkey [\nkey 5\nkey Ctrl+Shift+O\nwait\nstate " + path("closed.json") + "\nshot " +
               path("first.png") + "\nkey Ctrl+Shift+O\nsleep 0.3\ntype " + path("two/other.ply") +
               "\nkey Enter\nwait\nstate " + path("again.json") + "\nshot " + path("again.png") +
               "\nquit\n",
           {path("scene.ply"), "--beside", path("two/other.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json sides = state("sides.json"), closed = state("closed.json");
  EXPECT_EQ(sides["scene"], "scene");
  EXPECT_EQ(sides["split"]["scenes"], json({"scene", "other"}));
  EXPECT_EQ(sides["split"]["other"], "quadbox, cpu");
  EXPECT_THAT(sides["line"].get<std::string>(), StartsWith("scene | other"));
  EXPECT_THAT(state("flipped.json")["line"].get<std::string>(), StartsWith("other | scene"));
  EXPECT_EQ(state("moved.json")["split"]["other"], "exact, cpu");
  EXPECT_NE(state("moved.json")["split"]["PSNR"], sides["split"]["PSNR"]);
  EXPECT_FALSE(closed.contains("split"));
  EXPECT_THAT(closed["line"].get<std::string>(), StartsWith("quadbox"));
  EXPECT_EQ(state("again.json")["split"]["scenes"], sides["split"]["scenes"]);

  const Image first = read_image(path("first.png")), second = read_image(path("second.png"));
  EXPECT_LT(psnr_8bit(first, second), 25);
  EXPECT_EQ(sides["split"]["PSNR"], decibels(psnr_8bit(first, second)) + " dB");
  const struct {
    const char* file;
    int divider;
    bool flipped;
  } pictures[] = {{"sides.png", 160, false},
                  {"dragged.png", 80, false},
                  {"flipped.png", 80, true},
                  {"again.png", 80, false}};
  for (const auto& picture : pictures) {
    const Image shown = read_image(path(picture.file));
    for (int y = 40; y < 100; ++y) {  // rows that neither names nor the grip of the divider cover
      for (const int x : {10, 60, 100, 140, 200, 300}) {
        const Image& expected = (x < picture.divider) != picture.flipped ? first : second;
        for (int c = 0; c < 3; ++c)
          ASSERT_EQ(shown.at(x, y, c), expected.at(x, y, c))
              << picture.file << " " << x << " " << y;
      }
    }
  }
}

TEST_F(ViewerProgram, a_scene_beside_needs_a_scene_and_a_damaged_one_is_a_message) {
  const ProgramRun none = play("quit\n", {"--beside", path("scene.ply")});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr("name the scene to show it beside"));
  std::ofstream(folder_ / "bad.ply") << "ply\n";
  const ProgramRun bad = play("wait\nstate " + path("a.json") + "\nquit\n",
                              {path("scene.ply"), "--beside", path("bad.ply")});
  ASSERT_EQ(bad.exit_code, 0) << bad.err;
  EXPECT_EQ(state("a.json")["scene"], "scene");
  EXPECT_FALSE(state("a.json").contains("split"));
  EXPECT_THAT(state("a.json")["toasts"].dump(), HasSubstr("bad.ply"));
}

TEST_F(ViewerProgram, the_reference_stands_beside_the_view_once_it_was_asked_for) {
  const ProgramRun run = play(
      "key Tab\nwait\nstate " + path("before.json") + "\nkey 0\nwait\nstate " + path("whole.json") +
          "\nmove 100 120\nkey Shift+0\nwait\nstate " + path("part.json") + "\nquit\n",
      {path("scene.ply"), "--beside", "reference"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_FALSE(state("before.json").contains("split"));
  const json whole = state("whole.json")["split"], part = state("part.json")["split"];
  EXPECT_EQ(whole["other"], "reference");
  EXPECT_EQ(whole["region"], json({0, 0, 320, 240}));
  EXPECT_EQ(part["region"], json({0, 0, 228, 240}));
  for (const json& split : {whole, part}) {
    const std::string error = split["largest error"];
    EXPECT_TRUE(error == "0" || error.starts_with("1/255")) << error;
  }
}

TEST_F(ViewerProgram, refuses_to_stand_beside_what_there_is_not) {
  const ProgramRun run = play("quit\n", {path("scene.ply"), "--beside", "best"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("--beside: 'best' is neither a mode nor a file"));
}

TEST_F(ViewerProgram, the_map_of_missed_contributions_equals_the_command_s) {
  const ProgramRun run =
      play("key Tab\nwait\nkey 3\nkey H\nkey Shift+H\nkey Shift+H\nkey Shift+H\nwait\nstate " +
               path("a.json") + "\nkey 2\nwait\nstate " + path("b.json") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json map = state("a.json")["heatmap"];
  EXPECT_EQ(map["quantity"], "missed");
  EXPECT_GT(map["total"], 0);
  EXPECT_EQ(state("b.json")["heatmap"]["total"], 0);
  const ProgramRun render = run_quadsplat(
      {"render", path("scene.ply"), "--backend", "cpu", "--camera-index", "0", "--size", "320x240",
       "--cull", "dualbox", "--heatmap", "missed", "--output", path("missed.png")});
  ASSERT_EQ(render.exit_code, 0) << render.err;
  EXPECT_THAT(render.err, HasSubstr(map["missed"].get<std::string>()));
}

TEST_F(ViewerProgram, the_display_counts_unused_pairs_as_bench_does) {
  const ProgramRun run =
      play("key F10\nwait\nstate " + path("a.json") + "\nquit\n", {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json measured = state("a.json")["measured_size"];
  const std::uint64_t count = benched_false_positives(measured[0], measured[1]);
  EXPECT_THAT(state("a.json")["facts"]["unused"].get<std::string>(),
              StartsWith(grouped(count) + " pairs"));
}

TEST_F(ViewerProgram, the_map_of_false_positives_adds_up_to_the_count_of_bench) {
  const ProgramRun run =
      play("key F10\nkey H\nkey Shift+H\nkey Shift+H\nwait\nstate " + path("a.json") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json a = state("a.json");
  EXPECT_EQ(a["heatmap"]["quantity"], "false-positive");
  EXPECT_EQ(a["heatmap"]["total"],
            benched_false_positives(a["camera"]["width"], a["camera"]["height"]));
}

TEST_F(ViewerProgram, a_key_reads_the_file_as_if_its_axes_were_others) {
  const ProgramRun run =
      play("wait\nstate " + path("a.json") + "\nkey Y\nwait\nstate " + path("b.json") + "\nshot " +
               path("turned.png") + "\nkey F5\nwait\nstate " + path("c.json") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(state("a.json")["axes"], "");
  EXPECT_EQ(state("b.json")["axes"], "RFU");
  EXPECT_EQ(state("c.json")["axes"], "RFU");
  EXPECT_NE(state("b.json")["facts"]["tile pairs"], state("a.json")["facts"]["tile pairs"]);
}

TEST_F(ViewerProgram, a_file_that_seems_upside_down_is_turned_by_one_key_for_good) {
  test::SceneBuilder builder(3);
  builder.disc(3000, {0, 0, 0}, {0, -1, 0}, 2);
  builder.ball(2000, {0, -0.5f, 0}, 0.5f);
  flip_axes(builder.cloud, 0, builder.cloud.size(), kTurnAboutX);
  const TemporaryFolder folder;  // without cameras
  const std::string scene = (folder / "hanging.ply").string(), settings = path("settings.json");
  test::write_scene(builder.cloud, scene);
  const std::string states = "wait\nstate " + path("a.json") + "\n";
  ASSERT_EQ(play(states + "key Y\nwait\nstate " + path("b.json") + "\nquit\n",
                 {scene, "--settings", settings})
                .exit_code,
            0);
  const auto says = [](const json& state) {
    return state["toasts"].dump().find("upside down") != std::string::npos;
  };
  EXPECT_TRUE(says(state("a.json")));
  EXPECT_EQ(state("b.json")["axes"], "RUB");
  ASSERT_EQ(play(states + "quit\n", {scene, "--settings", settings}).exit_code, 0);
  EXPECT_EQ(state("a.json")["axes"], "RUB");
  EXPECT_FALSE(says(state("a.json")));
}

TEST_F(ViewerProgram, a_file_that_was_turned_upright_stays_so_after_a_restart) {
  const std::string settings = path("settings.json");
  for (const char* script : {"wait\nkey Y\nwait\n", "wait\n"}) {
    const ProgramRun run = play(script + ("state " + path("a.json")) + "\nquit\n",
                                {path("scene.ply"), "--settings", settings});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(state("a.json")["axes"], "RFU");
  }
}

TEST_F(ViewerProgram, typing_into_the_dialog_open_fires_no_shortcut_and_enter_opens_the_path) {
  // Its letters would show a heat map, measure the view, record a zoom and compare.
  std::filesystem::copy(path("scene.ply"), path("hpz0.ply"));
  const ProgramRun run =
      play("wait\nkey Ctrl+O\ntype hpz0.ply\nsleep 0.2\nstate " + path("typed.json") +
               "\nkey Enter\nwait\nstate " + path("opened.json") +
               "\nkey Ctrl+O\nsleep 0.2\ntype H\nkey Escape\nsleep 0.2\nstate " +
               path("closed.json") + "\nkey H\nwait\nstate " + path("map.json") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json typed = state("typed.json"), opened = state("opened.json");
  EXPECT_TRUE(typed["open_dialog"]);
  EXPECT_EQ(typed["scene"], "scene");
  EXPECT_FALSE(opened["open_dialog"]);
  EXPECT_EQ(opened["scene"], "hpz0");
  for (const json& shown : {typed, opened}) {
    EXPECT_FALSE(shown.contains("heatmap"));
    EXPECT_FALSE(shown.contains("oracle"));
    EXPECT_EQ(shown["zoom"]["rows"], 0);
  }
  EXPECT_FALSE(std::filesystem::exists(path("bench")));
  EXPECT_FALSE(state("closed.json")["open_dialog"]);
  EXPECT_FALSE(state("closed.json").contains("heatmap"));
  EXPECT_TRUE(state("map.json").contains("heatmap"));
}

TEST_F(ViewerProgram, an_idle_window_shows_that_its_measurement_has_finished) {
  std::string script = "key F10\n";
  for (const char* name : {"0", "1", "2", "3"})
    script += "sleep 0.1\nwait\nsleep 0.5\nstate " + path(name) + "\nwheel 1\n";
  const ProgramRun run = play(script + "quit\n", {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* name : {"0", "1", "2", "3"})
    EXPECT_THAT(state(name)["status"].get<std::string>(),
                StartsWith("all modes measured off screen for this view"))
        << name;
}

TEST_F(ViewerProgram, the_reference_s_verdict_stays_in_a_panel_until_the_view_changes) {
  const ProgramRun run =
      play("key 3\nwait\nsleep 0.5\nshot " + path("before.png") + "\nkey 0\nwait\nstate " +
               path("a.json") + "\nsleep 6\nshot " + path("panel.png") + "\nstate " +
               path("b.json") + "\nwheel 1\nwait\nstate " + path("c.json") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json a = state("a.json"), b = state("b.json");
  EXPECT_EQ(a["verdict"]["frame"], "dualbox, cpu");
  EXPECT_THAT(a["verdict"]["verdict"].get<std::string>(), HasSubstr("differ by more than 2/255"));
  EXPECT_THAT(a["verdict"]["first pixel"].get<std::string>(), HasSubstr("in tile"));
  EXPECT_EQ(b["verdict"], a["verdict"]);
  EXPECT_FALSE(state("c.json").contains("verdict"));
  // Longer than a message stays, the panel still covers the lower left of the picture.
  const Image before = read_image(path("before.png")), panel = read_image(path("panel.png"));
  int covered = 0;
  for (int y = 120; y < 210; ++y) {
    for (int x = 20; x < 200; ++x)
      covered += std::abs(panel.at(x, y, 0) - before.at(x, y, 0)) > 2.0f / 255 ? 1 : 0;
  }
  EXPECT_GT(covered, 90 * 180 / 2);
}

TEST_F(ViewerProgram, a_signal_to_end_closes_the_window_and_saves_the_settings) {
  for (const int signal : {SIGTERM, SIGINT}) {
    std::filesystem::remove(path("ready.json"));
    std::filesystem::remove(path("kept.json"));
    const auto end = [&](pid_t program) {
      for (int i = 0; i < 600 && !std::filesystem::exists(path("ready.json")); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      kill(program, signal);
    };
    const ProgramRun run =
        play("wait\nkey V\nwheel 2\nwait\nstate " + path("ready.json") + "\nsleep 100\n",
             {path("scene.ply"), "--settings", path("kept.json")}, end);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const json kept = state("kept.json");
    EXPECT_EQ(kept["navigation"], "fly");
    EXPECT_EQ(json::parse(kept["cameras"][path("scene.ply")].get<std::string>()),
              state("ready.json")["camera"]);
  }
}

TEST_F(ViewerProgram, the_program_s_name_alone_opens_the_window) {
  setenv("XDG_CONFIG_HOME", path("config").c_str(), 1);
  const auto end = [&](pid_t program) {
    std::this_thread::sleep_for(std::chrono::seconds(3));
    kill(program, SIGTERM);
  };
  const ProgramRun run = run_quadsplat({}, end);
  unsetenv("XDG_CONFIG_HOME");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const json kept = state("config/quadsplat/viewer.json");
  EXPECT_THAT(kept["recent"].dump(), HasSubstr("plush.ply"));
  EXPECT_EQ(kept["hud"], false) << "a window of 1024 pixels";
}

TEST_F(ViewerProgram, keyframes_mode_and_map_are_kept_edits_are_offered_and_the_scale_is_not) {
  const std::vector<std::string> arguments = {path("scene.ply"), "--settings", path("kept.json")};
  const ProgramRun run = play(
      "wait\nkey K\nkey ]\nwait\nkey K\ncrop -9,-9,-9,0,9,9\nkey Shift+R\nwait\nkey 2\nkey H\n"
      "key -\nwait\nstate " +
          path("a.json") + "\nkey Ctrl+Q\nsleep 100\n",
      arguments);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  ASSERT_EQ(
      play("wait\nstate " + path("b.json") + "\nkey Ctrl+Z\nstate " + path("c.json") + "\ndrop " +
               path("scene.ply.edits.json") + "\nwait\nstate " + path("d.json") + "\nquit\n",
           arguments)
          .exit_code,
      0);
  const json a = state("a.json"), b = state("b.json");
  EXPECT_EQ(b["keyframes"], 2);
  EXPECT_FALSE(b.contains("crop")) << "never silently";
  EXPECT_THAT(b["toasts"].dump(), HasSubstr("scene.ply.edits.json has edits of this scene"));
  EXPECT_LT(a["gaussians"], b["gaussians"]);
  const json d = state("d.json");
  EXPECT_EQ(d["crop"]["text"], a["crop"]["text"]);
  EXPECT_EQ(d["gaussians"], a["gaussians"]);
  EXPECT_EQ(b["mode"], "adr");
  EXPECT_EQ(b["heatmap"]["quantity"], "pairs");
  EXPECT_EQ(state("c.json")["keyframes"], 2) << "nothing was changed in this run";
}

TEST_F(ViewerProgram, leaving_asks_what_to_do_with_work_that_no_settings_keep) {
  std::filesystem::copy(path("scene.ply"), path("other.ply"));
  const ProgramRun run =
      play("wait\nkey K\nkey K\nkey Ctrl+Q\nsleep 0.2\nkey H\nstate " + path("a.json") +
               "\nkey Escape\nsleep 0.2\ndrop " + path("other.ply") + "\nsleep 0.2\nstate " +
               path("b.json") + "\nshot " + path("asks.png") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(state("a.json")["leaving"], "2 keyframes");
  EXPECT_FALSE(state("a.json").contains("heatmap")) << "keys do nothing else";
  EXPECT_EQ(state("b.json")["leaving"], "2 keyframes");
  EXPECT_EQ(state("b.json")["scene"], "scene");
}

TEST_F(ViewerProgram, settings_and_the_last_view_are_kept) {
  const std::vector<std::string> arguments = {path("scene.ply"), "--settings", path("kept.json")};
  ASSERT_EQ(
      play("wait\nkey F10\nkey V\nwheel 3\nwait\nstate " + path("a.json") + "\nquit\n", arguments)
          .exit_code,
      0);
  ASSERT_EQ(play("wait\nstate " + path("b.json") + "\nquit\n", arguments).exit_code, 0);
  EXPECT_EQ(state("a.json")["camera"], state("b.json")["camera"]);
  const json kept = state("kept.json");
  EXPECT_EQ(kept["hud"], true);
  EXPECT_EQ(kept["navigation"], "fly");
  EXPECT_EQ(kept["recent"][0], path("scene.ply"));
  std::ofstream(folder_ / "kept.json") << "{ damaged";
  ASSERT_EQ(play("wait\nstate " + path("c.json") + "\nquit\n", arguments).exit_code, 0);
  EXPECT_THAT(state("c.json")["toasts"].dump(), HasSubstr("ignored"));
}

}  // namespace
}  // namespace qs
