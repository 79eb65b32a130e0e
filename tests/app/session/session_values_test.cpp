// SPDX-License-Identifier: MIT
//
// Words of the command line, texts of numbers, photographs: exact values and messages, at every
// limit.
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/framing/first_view.h"
#include "app/framing/scene_box.h"
#include "app/framing/up_axis.h"
#include "app/report/scene_report.h"
#include "app/session/placed_cameras.h"
#include "app/session/removal_text.h"
#include "app/session/session.h"
#include "app/support/terminal.h"
#include "base/assets.h"
#include "base/error.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "io/camera/photographs.h"
#include "io/picture/image_file.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using namespace std::chrono_literals;
using test::error_of;
using testing::ElementsAre;

TEST(Text, numbers_are_accepted_at_both_ends_of_their_range) {
  EXPECT_EQ(parse_integer("--n", "-3", -3, 7), -3);
  EXPECT_EQ(parse_integer("--n", "7", -3, 7), 7);
  for (const char* text : {"-4", "8", "", "x", "3x", " 3", "3.0"}) {
    EXPECT_EQ(error_of([&] { parse_integer("--n", text, -3, 7); }),
              std::string("--n: '") + text + "' is not a whole number from -3 to 7");
  }
  EXPECT_EQ(parse_bytes("--b", "1234"), 1234u);
  EXPECT_EQ(parse_bytes("--b", "64K"), 64'000u);
  EXPECT_EQ(parse_bytes("--b", "1.5G"), 1'500'000'000u);
  EXPECT_EQ(parse_bytes("--b", "2T"), 2'000'000'000'000u);
  EXPECT_EQ(parse_bytes("--b", "1GB"), 1'000'000'000u);
  EXPECT_EQ(parse_bytes("--b", "16MiB"), 16u << 20);
  EXPECT_EQ(parse_bytes("--b", "0.5KiB"), 512u);
  for (const char* text : {"", "G", "1.5g", "1B", "1iB", "GB", "MiB", "1GiBB", "-1M", "0", "0.1",
                           "inf", "nan", "9999999999T"}) {
    EXPECT_EQ(error_of([&] { parse_bytes("--b", text); }),
              fmt::format("--b: '{}' is not a number of bytes such as 800M or 1.5G", text));
  }
  EXPECT_EQ(parse_real("--r", "0.5", 0.5, 2), 0.5);
  EXPECT_EQ(parse_real("--r", "2", 0.5, 2), 2);
  EXPECT_EQ(parse_real("--r", "1.25e0", 0.5, 2), 1.25);
  for (const char* text : {"0.49", "2.01", "", "nan", "1,5"}) {
    EXPECT_EQ(error_of([&] { parse_real("--r", text, 0.5, 2); }),
              std::string("--r: '") + text + "' is not a number from 0.5 to 2");
  }
}

TEST(Text, sizes_and_colors_are_accepted_at_both_ends_of_their_range) {
  EXPECT_EQ(parse_size("--size", "1x32768"), glm::ivec2(1, 32768));
  EXPECT_EQ(parse_size("--size", "32768x1"), glm::ivec2(32768, 1));
  for (const char* text :
       {"0x5", "5x0", "32769x5", "5x32769", "5", "x", "5x", "x5", "5x5x5", "axb"}) {
    EXPECT_EQ(error_of([&] { parse_size("--size", text); }),
              std::string("--size: '") + text + "' is not WIDTHxHEIGHT with sides from 1 to 32768");
  }
  EXPECT_EQ(parse_color("--c", "0,1,0.25"), glm::vec3(0, 1, 0.25f));
  for (const char* text :
       {"0,1", "0,1,2", "-0.1,1,1", "0,1.01,0", "0,0,0,0", "", "a,b,c", "0,,0", "0,0,"}) {
    EXPECT_EQ(error_of([&] { parse_color("--c", text); }),
              std::string("--c: '") + text + "' is not R,G,B with values from 0 to 1");
  }
}

TEST(Text, lists_are_joined_and_separated) {
  const std::vector<std::string> words = {"a", "b", "c"};
  EXPECT_EQ(joined(words, ", "), "a, b, c");
  EXPECT_EQ(joined({}, ", "), "");
  EXPECT_THAT(separated("a,b,"), ElementsAre("a", "b", ""));
  EXPECT_THAT(separated(""), ElementsAre(""));
  EXPECT_THAT(separated("a b;c", ';'), ElementsAre("a b", "c"));
  EXPECT_EQ(csv_field("plain"), "plain");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("say \"hi\""), "\"say \"\"hi\"\"\"");
  EXPECT_EQ(csv_field("a\nb"), "\"a\nb\"");
  EXPECT_EQ(csv_field("a\rb"), "\"a\rb\"");
}

TEST(Text, of_markdown_stays_in_its_cell) {
  EXPECT_EQ(markdown_text("a|b\\c\nd<e"), "a\\|b\\\\c d\\<e");
  EXPECT_EQ(markdown_code("a|b`c"), "`a\\|b'c`");
}

TEST(Text, words_reach_a_shell_whole) {
  for (const char* word : {"a/b-c_d.ply", "0.5,1", "--size"}) EXPECT_EQ(shell_word(word), word);
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("my photos"), "'my photos'");
  EXPECT_EQ(shell_word("*$HOME;"), "'*$HOME;'");
  EXPECT_EQ(shell_word("it's"), R"('it'\''s')");
}

TEST(Text, large_numbers_are_grouped_and_have_units) {
  const std::pair<std::uint64_t, const char*> groups[] = {{0, "0"},
                                                          {999, "999"},
                                                          {1000, "1,000"},
                                                          {12345, "12,345"},
                                                          {999999, "999,999"},
                                                          {1000000, "1,000,000"},
                                                          {1796342, "1,796,342"}};
  for (const auto& [number, text] : groups) EXPECT_EQ(grouped(number), text);
  const std::pair<std::uint64_t, const char*> sizes[] = {{0, "0 bytes"},
                                                         {999, "999 bytes"},
                                                         {1000, "1.0 kB"},
                                                         {999949, "999.9 kB"},
                                                         {999950, "1.0 MB"},
                                                         {18039653, "18.0 MB"},
                                                         {999949999, "999.9 MB"},
                                                         {2500000000, "2.5 GB"},
                                                         {3200000000000, "3.2 TB"},
                                                         {4000000000000000, "4000.0 TB"}};
  for (const auto& [bytes, text] : sizes) EXPECT_EQ(bytes_text(bytes), text);
  EXPECT_EQ(decibels(INFINITY), "inf");
  EXPECT_EQ(decibels(38.256), "38.26");
}

// ---- progress -----------------------------------------------------------------------------------

TEST(ProgressBar, the_time_left_is_that_of_the_same_speed) {
  const std::string empty = "a [" + std::string(32, ' ') + "]   0 %";
  EXPECT_EQ(progress_line("a", 0, 100), empty);
  EXPECT_EQ(progress_line("a", 1 / 1024.0f, 0.5), empty + ", 8:32 left");  // 511.5 s
  EXPECT_EQ(progress_line("a", 1 / 8192.0f, 2), empty + ", 4:33:02 left");
  EXPECT_EQ(progress_line("", 0.25f, 10),
            " [" + std::string(8, '#') + std::string(24, ' ') + "]  25 %, 0:30 left");
}

TEST(ProgressBar, a_part_of_the_work_is_a_part_of_the_bar) {
  std::vector<float> seen;
  const Progress whole{[&](float fraction) { seen.push_back(fraction); }, {}};
  const Progress part = part_of(part_of(whole, 0.5f, 1), 0, 0.5f);
  for (const float fraction : {0.0f, 0.5f, 1.0f}) part.update(fraction);
  EXPECT_EQ(seen, (std::vector<float>{0.5f, 0.625f, 0.75f}));
  EXPECT_FALSE(part_of(Progress(), 0, 1).report);
}

TEST(ProgressBar, appears_after_a_third_of_a_second_and_says_how_long_it_takes) {
  const auto bar = [](std::size_t filled, const char* rest) {
    return "\rreading [" + std::string(filled, '#') + std::string(32 - filled, ' ') + "] " + rest;
  };
  const test::Terminal terminal;
  {
    ProgressBar::Clock::time_point now{};
    ProgressBar progress_bar("reading", [&] { return now; });
    const Progress progress = progress_bar.progress();
    const auto shown_after = [&](std::chrono::milliseconds time, float fraction) {
      now += time;
      progress.update(fraction);
      return terminal.shown();
    };
    EXPECT_EQ(shown_after(299ms, 0.5f), "");
    EXPECT_EQ(shown_after(1ms, 0), bar(0, "  0 %\033[K"));
    EXPECT_EQ(shown_after(0ms, 0.005f), bar(0, "  0 %, 1:00 left\033[K"))
        << "from the first step on";
    EXPECT_EQ(shown_after(499ms, 0.006f), "");
    EXPECT_EQ(shown_after(1ms, 0.008f), bar(0, "  0 %, 1:39 left\033[K"));
    EXPECT_EQ(shown_after(0ms, 0.5f), bar(16, " 50 %, 0:01 left\033[K"));
    EXPECT_EQ(shown_after(0ms, 7), bar(32, "100 %, 0:00 left\033[K"));
  }
  EXPECT_EQ(terminal.shown(), "\r\033[K");
  { ProgressBar silent("reading"); }
  EXPECT_EQ(terminal.shown(), "");
}

// ---- photographs --------------------------------------------------------------------------------
TEST(Photographs, gray_and_transparent_pictures_become_rgb_over_the_background) {
  const TemporaryFolder folder;
  const glm::vec3 background(0.2f, 0.4f, 0.6f);
  const float stored[] = {51 / 255.0f, 102 / 255.0f, 204 / 255.0f, 153 / 255.0f};
  for (int channels = 1; channels <= 4; ++channels) {
    SCOPED_TRACE(channels);
    Image image(3, 2, channels);
    for (int c = 0; c < channels; ++c) image.at(2, 1, c) = stored[c];
    write_image(image, folder / "a.png");
    const Image read = read_photograph(folder / "a.png", background, 1, test::pool(1));
    ASSERT_EQ(read.channels, 3);
    ASSERT_EQ(read.width, 3);
    ASSERT_EQ(read.height, 2);
    const float alpha = channels == 2 ? stored[1] : channels == 4 ? stored[3] : 1;
    for (int c = 0; c < 3; ++c) {
      const float value = channels < 3 ? stored[0] : stored[c];
      EXPECT_NEAR(read.at(2, 1, c), value * alpha + background[c] * (1 - alpha), 1e-6);
      EXPECT_NEAR(read.at(0, 0, c), channels % 2 == 0 ? background[c] : 0, 1e-6);
    }
  }
  write_image(Image(7, 5, 3), folder / "b.png");
  const auto size = [&](int divisor) {
    const Image read = read_photograph(folder / "b.png", background, divisor, test::pool(1));
    return glm::ivec2(read.width, read.height);
  };
  EXPECT_EQ(size(2), glm::ivec2(4, 3));  // rounded
  EXPECT_EQ(size(4), glm::ivec2(2, 1));
  EXPECT_EQ(size(3), glm::ivec2(2, 2));
  EXPECT_EQ(size(100), glm::ivec2(1, 1));
}

// ---- georeferenced scenes -----------------------------------------------------------------------
TEST(Origins, boxes_are_written_and_read_in_the_world) {
  const glm::dvec3 origin(500000, 5700000, 100);
  const CropBox box = parse_crop_box("--crop", "500001.25,5700002.5,99,500003,5700004,101", origin);
  EXPECT_EQ(box.low, glm::vec3(1.25f, 2.5f, -1));
  EXPECT_EQ(box.high, glm::vec3(3, 4, 1));
  const std::string text = format_crop_box(box, origin);
  EXPECT_EQ(text, "500001.25,5700002.5,99,500003,5700004,101");
  const CropBox again = parse_crop_box("--crop", text, origin);
  EXPECT_EQ(again.low, box.low);
  EXPECT_EQ(again.high, box.high);
}

TEST(Origins, reports_have_the_digits_that_tell_places_apart) {
  Scene scene;
  scene.cloud = test::random_cloud(2, 0, 3);
  scene.cloud.positions[0] = {1.25f, 2.5f, 0};
  scene.cloud.positions[1] = {3.25f, 4.5f, 1};
  scene.cloud.origin = {500000, 5700000, 100};
  const SceneReport report = make_report(scene.cloud);
  const std::string text = report_text(scene, report);
  EXPECT_THAT(text, testing::HasSubstr("500000 5700000 100\n"));
  EXPECT_THAT(text,
              testing::HasSubstr("(500001.25, 5700002.5, 100) to (500003.25, 5700004.5, 101)\n"));
  EXPECT_EQ(report_json(scene, report)["extents"]["low"][1], 5700002.5);
}

TEST(Origins, cameras_see_a_scene_if_one_of_them_does) {
  GaussianCloud cloud = test::random_cloud(50, 0, 3);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.positions[i] = {0, 0, 5};
    cloud.log_scales[i] = glm::vec3(-3);
  }
  const Camera ahead = test::front_camera(40, 30);
  Camera away = ahead;
  away.view_from_world = glm::dmat4x3(-1, 0, 0, 0, 1, 0, 0, 0, -1, 0, 0, 0);
  EXPECT_TRUE(sees_scene({ahead}, cloud));
  EXPECT_FALSE(sees_scene({away}, cloud));
  EXPECT_TRUE(sees_scene({away, away, ahead}, cloud));
  EXPECT_FALSE(sees_scene({}, cloud));
  EXPECT_FALSE(sees_scene({ahead}, GaussianCloud()));
  // A large Gaussian beside the picture reaches into it.
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.positions[i] = {50, 0, 5};
  EXPECT_FALSE(sees_scene({ahead}, cloud));
  cloud.log_scales[7] = glm::vec3(4);
  EXPECT_TRUE(sees_scene({ahead}, cloud));
}

// ---- boxes and framing --------------------------------------------------------------------------
TEST(SceneBox, quantiles_are_rounded_to_the_nearest_value) {
  GaussianCloud cloud;
  cloud.resize(4, 0);
  for (std::size_t i = 0; i < 4; ++i) cloud.positions[i] = glm::vec3(static_cast<float>(3 - i));
  const auto low = [&](double fraction) { return scene_box(cloud, fraction, 1).low.x; };
  EXPECT_EQ(low(0), 0);
  EXPECT_EQ(low(0.16), 0);
  EXPECT_EQ(low(0.17), 1);
  EXPECT_EQ(low(1), 3);
  EXPECT_EQ(scene_box(GaussianCloud(), 0, 1).size(), SceneBox().size());
}

TEST(Framing, small_scenes_and_up_axes_have_exact_values) {
  EXPECT_EQ(smallest_framing(GaussianCloud()), 1e-3f);
  GaussianCloud cloud;
  cloud.resize(2, 0);
  cloud.log_scales = {{-9, -1, -9}, {-2, -9, -9}};
  EXPECT_NEAR(smallest_framing(cloud), 3 * std::exp(-1.0f), 1e-6);  // the upper of two
  cloud.log_scales = {{99, 0, 0}, {99, 0, 0}};
  EXPECT_EQ(smallest_framing(cloud), 1e-3f);
  EXPECT_EQ(world_up("-x"), glm::dvec3(-1, 0, 0));
  EXPECT_EQ(world_up("X"), glm::dvec3(1, 0, 0));
  EXPECT_EQ(world_up("y"), glm::dvec3(0, 1, 0));
  EXPECT_EQ(world_up("-Z"), glm::dvec3(0, 0, -1));
  EXPECT_EQ(world_up("+z"), glm::dvec3(0, 0, 1));
  EXPECT_EQ(world_up("--z"), glm::dvec3(0, -1, 0));
  EXPECT_EQ(parse_direction("--up", "-y"), glm::dvec3(0, -1, 0));
  EXPECT_EQ(parse_direction("--up", "z"), glm::dvec3(0, 0, 1));
  EXPECT_EQ(parse_direction("--up", "0,3,-4"), glm::dvec3(0, 0.6, -0.8));
  for (const char* wrong : {"", "w", "0,0,0", "1,2", "1,2,3,4", "nan,0,0", "inf,0,0"})
    EXPECT_THROW(parse_direction("--up", wrong), Error) << wrong;
  EXPECT_EQ(declared_up({}, ""), std::nullopt);
  EXPECT_EQ(declared_up({}, "z"), glm::dvec3(0, 0, 1));
  EXPECT_EQ(declared_up(glm::dvec3(1, 0, 0), "z"), glm::dvec3(1, 0, 0));
  // The near plane is a hundredth of the longest side, or of the sphere around the box.
  const SceneBox flat{{0, 0, 0}, {0, 4, 0}};
  EXPECT_NEAR(frame_box(flat, 0.1f, {0, -1, 0}, 64, 48).near_depth, 0.01 * 4 * 1.15, 1e-9);
  EXPECT_NEAR(frame_box({{0, 0, 0}, {0, 0, 0}}, 0.1f, {0, -1, 0}, 64, 48).near_depth,
              0.01 * 2 * 0.115, 1e-9);
  EXPECT_EQ(frame_box({{0, 0, 0}, {99, 1, 1}}, 0.1f, {0, -1, 0}, 64, 48).near_depth, 0.2);
}

TEST(SessionMessages, say_what_runs_on_the_cpu_only) {
  const TemporaryFolder folder;
  FrameOptions frame;
  frame.scene = folder / "scene.ply";
  test::write_scene(test::random_cloud(5, 0, 1), frame.scene);
  frame.backend = Backend::cuda;
  frame.settings.tile_px = 32;
  EXPECT_EQ(error_of([&] { open_session(frame); }), "--tile-size 32 runs with --backend cpu only");
  frame.settings.tile_px = kTileSize;
  frame.modes = {1, kReferenceMode};
  EXPECT_EQ(error_of([&] { open_session(frame); }),
            "--cull reference runs with --backend cpu only");
  frame.backend = Backend::cpu;
  const Session session = open_session(frame);
  EXPECT_STREQ(pipeline_name(session.backend, session.settings.pipeline), "cpu");
  const std::vector<CullMode> modes = all_modes();
  ASSERT_EQ(modes.size(), static_cast<std::size_t>(culler_count()));
  for (std::size_t i = 0; i < modes.size(); ++i) EXPECT_EQ(modes[i], static_cast<CullMode>(i + 1));
  const std::vector<CullMode> peers = peer_modes();
  ASSERT_EQ(peers.size(), static_cast<std::size_t>(mode_count() - culler_count()));
  for (std::size_t i = 0; i < peers.size(); ++i) {
    EXPECT_EQ(peers[i], culler_count() + static_cast<CullMode>(i + 1));
    EXPECT_EQ(row_of(peers[i]).family, CullerFamily::peers);
  }
  EXPECT_FALSE(find_asset("assets/no such file"));
  EXPECT_TRUE(find_asset("assets/cameras.json"));
}

}  // namespace
}  // namespace qs
