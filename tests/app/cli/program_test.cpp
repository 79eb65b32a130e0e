// SPDX-License-Identifier: MIT
//
// The program as users run it: exit codes, output to stdout and stderr, written files.
#include <cmath>
#include <cstdlib>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/support/run_program.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/cloud/axes.h"
#include "io/picture/image_file.h"
#include "io/scene/reader.h"
#include "io/scene/writer.h"
#include "raster/api/renderer.h"
#include "support/built_scenes.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using nlohmann::json;
using test::ProgramRun;
using test::run_quadsplat;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class Program : public testing::Test {
 protected:
  void SetUp() override {
    test::write_scene(test::random_cloud(500, 3, 11), scene_);
    std::vector<Camera> cameras;
    for (const char* name : {"first", "second one", ""}) {
      Camera camera = test::front_camera(64, 48);
      camera.name = name;
      cameras.push_back(camera);
    }
    test::write_cameras(cameras, folder_ / "cameras.json");
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  ProgramRun render(std::vector<std::string> options) const {
    options.insert(options.begin(), {"render", scene_});
    return run_quadsplat(options);
  }

  TemporaryFolder folder_;
  std::string scene_ = path("scene.ply");
};

// One sentence for the user, nothing on stdout.
void expect_failure(const ProgramRun& run, int exit_code, const std::string& part) {
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, StartsWith("quadsplat: "));
  EXPECT_THAT(run.err, HasSubstr(part));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
}

TEST_F(Program, every_command_answers_help_on_stdout) {
  for (const Command& command : commands()) {
    const ProgramRun run = run_quadsplat({command.name, "--help"});
    EXPECT_EQ(run.exit_code, kExitOk);
    EXPECT_THAT(run.out, HasSubstr(std::string("usage: quadsplat ") + command.name));
    EXPECT_THAT(run.out, HasSubstr("examples:"));
    EXPECT_EQ(run.err, "");
    EXPECT_THAT(run_quadsplat({"--help"}).out, HasSubstr(command.summary));
  }
}

TEST_F(Program, what_is_larger_than_the_scene_is_counted_and_left_out_on_request) {
  GaussianCloud cloud = test::random_cloud(500, 0, 11);
  cloud.log_scales[3] = cloud.log_scales[7] = glm::vec3(std::log(270.0f));
  cloud.opacity_logits[3] = cloud.opacity_logits[7] = 5;
  test::write_scene(cloud, path("covered.ply"));
  const auto draw = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"render", path("covered.ply"), "-o", path(name)};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramRun run = run_quadsplat(words);
    EXPECT_EQ(run.exit_code, kExitOk) << run.err;
    return run.err;
  };
  EXPECT_THAT(draw("all.png", {}),
              HasSubstr("2 Gaussians are larger than the scene; --skip-huge draws without"));
  EXPECT_THAT(draw("fewer.png", {"--skip-huge"}),
              HasSubstr("2 Gaussians are larger than the scene: left out"));
  EXPECT_NE(read_image(path("all.png")).values, read_image(path("fewer.png")).values);
  EXPECT_THAT(run_quadsplat({"info", path("covered.ply")}).out,
              HasSubstr("2 Gaussians are larger than the scene"));
}

TEST_F(Program, a_scene_that_hangs_from_its_floor_gets_a_hint) {
  test::SceneBuilder builder(3);
  builder.disc(3000, {0, 0, 0}, {0, -1, 0}, 2);
  builder.ball(2000, {0, -0.5f, 0}, 0.5f);
  const TemporaryFolder folder;  // without cameras
  test::write_scene(builder.cloud, folder / "upright.ply");
  flip_axes(builder.cloud, 0, builder.cloud.size(), kTurnAboutX);
  test::write_scene(builder.cloud, folder / "hanging.ply");
  const auto said = [&](const char* name, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"render", (folder / name).string(),   "--size", "64x48",
                                      "-o",     (folder / "a.png").string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_quadsplat(words).err;
  };
  EXPECT_THAT(said("hanging.ply", {}),
              HasSubstr("hanging.ply seems to be upside down: try --axes RUB"));
  EXPECT_THAT(said("hanging.ply", {"--axes", "RUB"}), Not(HasSubstr("upside down")));
  EXPECT_THAT(said("upright.ply", {}), Not(HasSubstr("upside down")));
}

TEST_F(Program, version_names_version_and_commit) {
  const ProgramRun run = run_quadsplat({"--version"});
  EXPECT_EQ(run.exit_code, kExitOk);
  EXPECT_THAT(run.out, StartsWith("quadsplat 0."));
  EXPECT_THAT(run.out, HasSubstr("commit"));
}

TEST_F(Program, list_gpus_names_gpus_or_why_there_is_none) {
  const ProgramRun run = run_quadsplat({"--list-gpus"});
  EXPECT_EQ(run.exit_code, kExitOk);
  EXPECT_THAT(run.out, testing::AnyOf(HasSubstr("0: "), HasSubstr("no GPU can be used: ")));
  EXPECT_THAT(run.out, HasSubstr("driver: "));
  EXPECT_THAT(run.out, HasSubstr("this program: "));
}

TEST_F(Program, wrong_command_lines_end_with_1) {
  expect_failure(run_quadsplat({"info", scene_, "--bogus"}), kExitUsage,
                 "unknown option '--bogus'");
  expect_failure(run_quadsplat({"rendr", scene_}), kExitUsage,
                 "'rendr' is neither a command nor a file");
  expect_failure(run_quadsplat({"rendr"}), kExitUsage, "'rendr' is neither a command nor a file");
  expect_failure(render({}), kExitUsage, "--output is missing");
  expect_failure(render({"--output", path("a.png"), "--cull", "fast"}), kExitUsage,
                 "--cull: 'fast' is none of");
  expect_failure(render({"--output", path("a.png"), "--camera-index", "0", "--all-cameras"}),
                 kExitUsage, "exclude");
  expect_failure(render({"--output", path("a.png"), "--reference-threshold", "50"}), kExitUsage,
                 "needs --reference");
  expect_failure(render({"--output", path("a.png"), "--path-steps", "3"}), kExitUsage,
                 "use --repeats");
  expect_failure(render({"--output", path("a.png"), "--shard", "1/2"}), kExitUsage,
                 "--all-cameras or --camera-path");
  expect_failure(
      render({"--output", path("a.png"), "--all-cameras", "--shard", "1/2", "--heatmap", "pairs"}),
      kExitUsage, "needs --heatmap-max");
  // With a display it opens the window.
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  const ProgramRun alone = run_quadsplat({});
  EXPECT_EQ(alone.exit_code, kExitUsage);
  EXPECT_THAT(alone.err, HasSubstr("usage: quadsplat [view] SCENE"));
}

TEST_F(Program, heat_maps_of_lists_need_a_mode_with_lists) {
  for (const char* quantity : {"pairs", "false-positive", "missed"}) {
    expect_failure(
        render({"--cull", "quadbox,reference", "--heatmap", quantity, "--output", path("a.png")}),
        kExitUsage, std::string("--heatmap ") + quantity + ": mode reference has no tile lists");
  }
  const ProgramRun run =
      render({"--cull", "reference", "--heatmap", "evaluated", "--output", path("a.png")});
  EXPECT_EQ(run.exit_code, kExitOk) << run.err;
}

TEST_F(Program, bad_input_ends_with_2) {
  expect_failure(run_quadsplat({"info", path("none.ply")}), kExitInput, "none.ply");
  std::ofstream(folder_ / "broken.ply") << "ply\nnonsense";
  expect_failure(run_quadsplat({"info", path("broken.ply")}), kExitInput, "broken.ply");
  expect_failure(render({"--output", path("a.png"), "--camera-index", "3"}), kExitInput,
                 "cameras 0 to 2");
  expect_failure(render({"--output", path("a.png"), "--camera-json", "{}"}), kExitInput,
                 "rotation is missing");
  std::ofstream(folder_ / "cameras.json") << "[]";
  expect_failure(render({"--output", path("a.png")}), kExitInput, "holds no camera");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.png"));
}

TEST_F(Program, a_scene_without_a_display_says_what_to_do_instead) {
  unsetenv("DISPLAY");
  expect_failure(run_quadsplat({scene_, "--settings", "-"}), kExitDevice,
                 "view: there is no display");
}

TEST_F(Program, render_writes_a_picture_of_the_camera_s_size_with_camera_and_mode_in_it) {
  const ProgramRun run = render({"--camera-index", "1", "--output", path("out.png")});
  EXPECT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_EQ(run.out, "");
  const Image image = read_image(folder_ / "out.png");
  EXPECT_EQ(image.width, 64);
  EXPECT_EQ(image.height, 48);
  EXPECT_EQ(image.channels, 3);
  std::ifstream file(folder_ / "out.png", std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(content, HasSubstr(std::string("tEXtMode\0quadbox", 16)));
  EXPECT_THAT(content, HasSubstr("second one"));
}

TEST_F(Program, every_format_gets_the_same_picture) {
  for (const char* name : {"a.png", "a.ppm", "a.pfm", "a.exr", "a.jpg"}) {
    const ProgramRun run = render({"--output", path(name), "--camera-index", "0"});
    ASSERT_EQ(run.exit_code, kExitOk) << run.err;
    ASSERT_TRUE(std::filesystem::exists(folder_ / name)) << name;
  }
  const Image exact = read_image(folder_ / "a.pfm");
  EXPECT_EQ(psnr_8bit(read_image(folder_ / "a.png"), exact),
            std::numeric_limits<double>::infinity());
  EXPECT_EQ(psnr_8bit(read_image(folder_ / "a.ppm"), exact),
            std::numeric_limits<double>::infinity());
  // The program itself reads formats of the module, because leak checking is off there.
  EXPECT_EQ(
      render({"--camera-index", "0", "--reference", path("a.exr"), "--reference-threshold", "999"})
          .exit_code,
      kExitOk);
  EXPECT_EQ(
      render({"--camera-index", "0", "--reference", path("a.jpg"), "--reference-threshold", "30"})
          .exit_code,
      kExitOk);
}

TEST_F(Program, all_cameras_write_one_picture_each_with_number_and_name) {
  EXPECT_EQ(render({"--all-cameras", "--output", path("v.ppm"), "--size", "32x24"}).exit_code,
            kExitOk);
  for (const char* name : {"v_0000_first.ppm", "v_0001_second_one.ppm", "v_0002.ppm"}) {
    ASSERT_TRUE(std::filesystem::exists(folder_ / name)) << name;
    EXPECT_EQ(read_image(folder_ / name).width, 32);
  }
}

TEST_F(Program, a_part_is_shown_enlarged_in_each_picture_and_written_alone) {
  const std::vector<std::string> words = {"--camera-index", "0",          "--size",    "64x48",
                                          "--cull",         "adr,exact",  "--repeats", "1",
                                          "--output",       path("d.png")};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), words.begin(), words.end());
    return render(more);
  };
  ASSERT_EQ(with({"--part", "40,30,16,8"}).exit_code, kExitOk);
  for (const char* mode : {"adr", "exact"}) {
    const Image picture = read_image(folder_ / (std::string("d_") + mode + ".png"));
    const Image part = read_image(folder_ / (std::string("d_") + mode + "_part.png"));
    EXPECT_EQ(picture.width, 64);
    ASSERT_EQ(part.width, 40);
    ASSERT_EQ(part.height, 20);
    for (int x = 0; x < 40; ++x) EXPECT_EQ(picture.at(x, 7, 1), part.at(x, 7, 1)) << x;
  }
  ASSERT_EQ(with({"--part", "40,30,16,8", "--part-zoom", "4"}).exit_code, kExitOk);
  EXPECT_EQ(read_image(folder_ / "d_adr_part.png").width, 64);
  expect_failure(with({"--part", "50,30,16,8"}), kExitUsage,
                 "--part: it ends at 66,38, but the picture is 64 x 48");
  expect_failure(with({"--part", "0,0,40,8"}), kExitUsage, "enlarged 2.5 times it is 100 x 20");
  expect_failure(with({"--part", "1,2,3"}), kExitUsage, "--part: '1,2,3' is not X,Y,W,H");
  expect_failure(with({"--part", "0,0,8,8", "--heatmap", "pairs"}), kExitUsage, "excludes");
}

TEST_F(Program, a_camera_path_gives_numbered_pictures_at_a_fixed_time_step) {
  std::vector<Camera> keys;
  for (int i = 0; i < 3; ++i) {
    Camera camera = test::front_camera(64, 48);
    camera.view_from_world[3].x = 0.1 * i;
    keys.push_back(camera);
  }
  test::write_cameras(keys, folder_ / "path.json");
  const ProgramRun run = render({"--camera-path", path("path.json"), "--path-steps", "5", "--size",
                                 "32x24", "--output", path("p.ppm"), "--stats", path("s.json")});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  const json stats = parse_json(read_text_file(folder_ / "s.json", 1 << 26), "test");
  ASSERT_EQ(stats["frames"].size(), 5u);
  for (int i = 0; i < 5; ++i) {
    const std::filesystem::path picture = folder_ / ("p_000" + std::to_string(i) + ".ppm");
    ASSERT_TRUE(std::filesystem::exists(picture)) << picture;
    EXPECT_EQ(read_image(picture).width, 32);
    const Camera camera =
        parse_camera(stats["frames"][static_cast<std::size_t>(i)]["camera"].dump(), "stats");
    EXPECT_NEAR(camera.view_from_world[3].x, 0.05 * i, 1e-6);
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "p_0005.ppm"));
  expect_failure(render({"--camera-path", path("path.json"), "--all-cameras", "--output", "a.png"}),
                 kExitUsage, "exclude");
}

TEST_F(Program, cull_all_prints_the_mode_table_and_writes_every_mode) {
  const ProgramRun run =
      render({"--cull", "all", "--psnr", "--repeats", "1", "--output", path("m.png")});
  EXPECT_EQ(run.exit_code, kExitOk) << run.err;
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const CullerRow& row = row_of(mode);
    EXPECT_THAT(run.out, HasSubstr(std::string("\n") + row.name));
    EXPECT_THAT(run.out, HasSubstr(row.summary));
    EXPECT_TRUE(std::filesystem::exists(folder_ / (std::string("m_") + row.name + ".png")));
  }
  EXPECT_THAT(run.out, HasSubstr("PSNR dB"));
}

TEST_F(Program, stats_on_stdout_are_json_and_nothing_else) {
  const ProgramRun run =
      render({"--stats", "-", "--cull", "all", "--repeats", "2", "--camera-index", "0"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  const json stats = parse_json(run.out, "test");
  EXPECT_EQ(stats["frames"].size(), static_cast<std::size_t>(culler_count()));
  EXPECT_EQ(stats["scene"]["gaussians"], 500);
  EXPECT_EQ(stats["environment"]["backend"].get<std::string>().empty(), false);
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(test::read_scene(scene_).cloud, {});
  for (const json& frame : stats["frames"]) {
    RenderSettings settings;
    settings.mode = find_culler(frame["mode"].get<std::string>());
    const RenderStats& expected = renderer->render(test::front_camera(64, 48), settings).stats;
    EXPECT_EQ(frame["tile_pairs"], expected.tile_pairs);
    EXPECT_EQ(frame["visible"], expected.visible);
    EXPECT_EQ(frame["max_pairs_in_a_tile"], expected.max_pairs_in_a_tile);
    EXPECT_EQ(frame["pairs_per_visible"],
              static_cast<double>(expected.tile_pairs) / expected.visible);
    EXPECT_EQ(frame["width"], 64);
    EXPECT_EQ(frame["height"], 48);
    EXPECT_GT(frame["frame_ms"], 0);
    EXPECT_TRUE(frame["stage_ms"].contains("blend"));
    EXPECT_EQ(parse_camera(frame["camera"].dump(), "stats").width, 64);
  }
}

TEST_F(Program, the_heat_map_s_total_equals_the_statistics) {
  const ProgramRun run = render({"--heatmap", "pairs", "--output", path("h.png"), "--stats",
                                 path("s.json"), "--camera-index", "0"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  const json stats = parse_json(read_text_file(folder_ / "s.json", 1 << 26), "test");
  const auto pairs = stats["frames"][0]["tile_pairs"].get<std::uint64_t>();
  std::ifstream file(folder_ / "h.png", std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(content, HasSubstr(std::string("HeatmapTotal\0", 13) + std::to_string(pairs)));
  EXPECT_GT(read_image(folder_ / "h.png").height, 48);
}

TEST_F(Program, depth_is_written_as_floats_and_as_16_bits_with_its_step) {
  const ProgramRun floats =
      render({"--picture", "depth", "--camera-index", "0", "--output", path("d.npy")});
  ASSERT_EQ(floats.exit_code, kExitOk) << floats.err;
  EXPECT_THAT(floats.err, HasSubstr("64 x 48, depth: units)"));
  const Image depth = read_image(folder_ / "d.npy");
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(read_scene(scene_, test::pool()).cloud, {});
  Outputs outputs;
  outputs.depth = true;
  EXPECT_EQ(depth.values, renderer->render(test::front_camera(64, 48), {}, outputs).depth.expected);
  const ProgramRun steps = render({"--picture", "depth", "--camera-index", "0", "--depth-step",
                                   "0.01", "--output", path("d.png")});
  ASSERT_EQ(steps.exit_code, kExitOk) << steps.err;
  EXPECT_THAT(steps.err, HasSubstr("depth: steps of 0.01 units)"));
  const Image read = read_image(folder_ / "d.png");
  for (std::size_t i = 0; i < read.values.size(); ++i)
    EXPECT_NEAR(655.35f * read.values[i], depth.values[i], 0.0051f);
  std::ifstream file(folder_ / "d.png", std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(content, HasSubstr(std::string("UnitsPerStep\0", 13) + "0.01"));
}

TEST_F(Program, all_cameras_have_their_depth) {
  const ProgramRun run =
      render({"--picture", "median-depth", "--all-cameras", "--output", path("m.pfm")});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "m_0000_first.pfm")) << run.err;
}

TEST_F(Program, pictures_that_hold_no_depth_are_refused_before_anything_is_drawn) {
  const auto refuse = [&](std::vector<std::string> options, const std::string& part) {
    options.insert(options.end(), {"--picture", "depth"});
    expect_failure(render(options), kExitUsage, part);
  };
  refuse({"--output", path("d.jpg")}, "d.jpg would keep 8 bits: use .npy, .exr");
  refuse({"--output", path("d.png"), "--heatmap", "pairs"}, "--heatmap is drawn over colours");
  refuse({"--output", path("d.png"), "--reference", path("a.png")}, "--reference compares colours");
  refuse({"--output", path("d.png"), "--depth-step", "1e-9"}, "16 bits reach");
  expect_failure(render({"--output", path("d.png"), "--depth-step", "1"}), kExitUsage,
                 "--depth-step needs --picture depth");
}

TEST_F(Program, a_picture_below_the_threshold_ends_with_4_and_shows_the_difference) {
  ASSERT_EQ(render({"--output", path("a.png"), "--camera-index", "0"}).exit_code, kExitOk);
  const std::vector<std::string> same = {
      "--output",    path("b.png"), "--camera-index",        "0",
      "--reference", path("a.png"), "--reference-threshold", "90"};
  const ProgramRun equal = render(same);
  EXPECT_EQ(equal.exit_code, kExitOk);
  EXPECT_THAT(equal.out, HasSubstr("PSNR inf dB"));

  std::vector<std::string> other = same;
  other.insert(other.end(), {"--background", "0.5,0.5,0.5"});
  const ProgramRun different = render(other);
  EXPECT_EQ(different.exit_code, kExitComparison);
  EXPECT_THAT(different.err, HasSubstr("below the threshold of 90 dB"));
  const Image difference = read_image(folder_ / "b.difference.png");
  EXPECT_EQ(difference.width, 64);
  EXPECT_GT(*std::max_element(difference.values.begin(), difference.values.end()), 0.3f);

  std::vector<std::string> wrong_size = same;
  wrong_size.insert(wrong_size.end(), {"--size", "32x24"});
  EXPECT_EQ(render(wrong_size).exit_code, kExitInput);
}

TEST_F(Program, info_tells_facts_as_text_and_json) {
  const ProgramRun text = run_quadsplat({"info", scene_});
  EXPECT_EQ(text.exit_code, kExitOk);
  EXPECT_THAT(text.out, HasSubstr("Gaussians      500"));
  const ProgramRun list = run_quadsplat({"info", scene_, scene_, "--json", "-"});
  ASSERT_EQ(list.exit_code, kExitOk) << list.err;
  const json facts = parse_json(list.out, "test");
  ASSERT_EQ(facts.size(), 2u);
  EXPECT_EQ(facts[0]["gaussians"], 500);
  EXPECT_EQ(facts[0]["sh_degree"], 3);
  EXPECT_EQ(facts[0]["bytes"], std::filesystem::file_size(scene_));
  EXPECT_LE(facts[0]["extents"]["low"][0], facts[0]["extents_5_95"]["low"][0]);
}

TEST_F(Program, info_says_lens_faces_and_used_share_of_cameras_beside_a_scene) {
  EXPECT_THAT(run_quadsplat({"info", scene_}).out, HasSubstr("cameras.json (pinhole)"));
  const std::filesystem::path folder = folder_ / "wide", scene = folder / "scene.ply";
  const std::filesystem::path model = folder / "sparse/0";
  std::filesystem::remove(folder_ / "cameras.json");  // it would be preferred
  std::filesystem::create_directories(model);
  std::filesystem::copy_file(scene_, scene);
  std::ofstream(model / "images.txt") << "1 1 0 0 0 0 0 3 1 a.jpg\n\n2 1 0 0 0 0 0 4 1 b.jpg\n\n";
  struct Row {
    const char *lens, *line;
  };
  // The shares are from tests/golden/lenses.py.
  const Row rows[] = {
      {"PINHOLE 100 75 80 80 50 37", "wide/sparse/0/images.txt (pinhole)"},
      {"SIMPLE_FISHEYE 100 75 80 50 37.5",
       "(SIMPLE_FISHEYE, undistorted, 90 % of a photograph used)"},
      {"SIMPLE_FISHEYE 100 100 31.83 50 50",
       "(SIMPLE_FISHEYE, 5 faces each, 100 % of a photograph used)"},
      {"BOX 100 75 80", "cameras.txt: line 1: there is no camera model 'BOX'"},
  };
  for (const Row& row : rows) {
    std::ofstream(model / "cameras.txt") << "1 " << row.lens << "\n";
    const ProgramRun run = run_quadsplat({"info", scene.string()});
    EXPECT_EQ(run.exit_code, kExitOk) << run.err;
    EXPECT_THAT(run.out, HasSubstr("  cameras        ")) << row.lens;
    EXPECT_THAT(run.out, HasSubstr(row.line)) << row.lens;
  }
}

TEST_F(Program, convert_writes_a_scene_of_the_degree_asked_for) {
  const ProgramRun run = run_quadsplat({"convert", scene_, path("small.ply"), "--sh-degree", "1"});
  EXPECT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_EQ(run.out, "");
  const Scene before = test::read_scene(scene_), after = test::read_scene(folder_ / "small.ply");
  EXPECT_EQ(after.cloud.sh_degree, 1);
  ASSERT_EQ(after.cloud.size(), before.cloud.size());
  EXPECT_EQ(after.cloud.positions, before.cloud.positions);
  EXPECT_EQ(after.cloud.sh[4 * 7 + 3], before.cloud.sh[16 * 7 + 3]);
  EXPECT_EQ(run_quadsplat({"convert", scene_, path("x.unknown")}).exit_code, kExitUsage);
}

TEST_F(Program, convert_crops_and_drops_floaters_and_counts_them) {
  GaussianCloud cloud = test::random_cloud(200, 0, 3);
  for (std::size_t i = 0; i < cloud.size(); ++i) {  // a grid with 0.1 units from one to the next
    cloud.positions[i] = 0.1f * glm::vec3(i % 10, i / 10 % 10, i / 100);
    cloud.log_scales[i] = glm::vec3(std::log(0.1f));
    cloud.opacity_logits[i] = 2;
  }
  cloud.opacity_logits[7] = -9;
  cloud.log_scales[8] = glm::vec3(5);
  test::append(cloud, test::single_gaussian({0.5f, 0.5f, 5}, 0.05f, {1, 0, 0}, 2));
  test::write_scene(cloud, path("room.ply"));

  const ProgramRun floaters =
      run_quadsplat({"convert", path("room.ply"), path("clean.ply"), "--drop-floaters"});
  EXPECT_EQ(floaters.exit_code, kExitOk);
  EXPECT_THAT(floaters.err, HasSubstr("3 of 201 Gaussians dropped: 1 too faint, 1 too large, "
                                      "1 isolated\n"));
  EXPECT_EQ(test::read_scene(folder_ / "clean.ply").cloud.size(), 198u);

  const ProgramRun both = run_quadsplat({"convert", path("room.ply"), path("crop.ply"), "--crop",
                                         "-1,-1,-1,0.45,2,0.15", "--drop-floaters"});
  EXPECT_THAT(both.err, HasSubstr("101 of 201 Gaussians dropped: 101 outside of the box\n"));
  EXPECT_EQ(test::read_scene(folder_ / "crop.ply").cloud.positions[5], cloud.positions[10]);
}

TEST_F(Program, convert_refuses_boxes_that_leave_nothing_and_to_replace_the_scene) {
  const std::string before = read_text_file(scene_, 1 << 24);
  const auto refused = [&](const std::string& output, const std::string& box) {
    const ProgramRun run = run_quadsplat({"convert", scene_, output, "--crop", box});
    EXPECT_EQ(run.exit_code, kExitUsage) << run.err;
    return run.err;
  };
  EXPECT_THAT(refused(path("x.ply"), "0,0,1,1,1,0.5"),
              HasSubstr("--crop: '0,0,1,1,1,0.5' begins at z 1 and ends before it at 0.5"));
  EXPECT_THAT(refused(path("x.ply"), "0,0,1,1,1"), HasSubstr("is not X0,Y0,Z0,X1,Y1,Z1"));
  EXPECT_THAT(refused(path("x.ply"), "900,900,900,901,901,901"),
              HasSubstr("500 of 500 Gaussians would be dropped: 500 outside of the box; the "
                        "centres are in the box "));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x.ply"));
  EXPECT_THAT(refused(scene_, "-9,-9,-9,9,9,9"), HasSubstr("is an input of this command"));
  std::filesystem::create_symlink(scene_, folder_ / "link.ply");
  EXPECT_THAT(refused(path("link.ply"), "-9,-9,-9,9,9,9"),
              HasSubstr("is an input of this command"));
  EXPECT_EQ(read_text_file(scene_, 1 << 24), before);
}

TEST_F(Program, render_draws_the_cameras_of_a_list) {
  const ProgramRun run = render({"--camera-index", "2,0", "--output", path("two.png")});
  EXPECT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "two_0000_first.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "two_0002.png"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "two_0001_second_one.png"));
  expect_failure(run_quadsplat({"inspect", scene_, "--camera-index", "0,1"}), kExitUsage,
                 "choose one camera");
}

TEST_F(Program, without_cameras_the_scene_is_framed) {
  std::filesystem::remove(folder_ / "cameras.json");
  const ProgramRun run = render({"--output", path("f.png"), "--size", "80x60"});
  EXPECT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_THAT(run.err, HasSubstr("framing"));
  EXPECT_EQ(read_image(folder_ / "f.png").width, 80);
}

}  // namespace
}  // namespace qs
