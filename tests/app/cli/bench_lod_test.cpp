// SPDX-License-Identifier: MIT
//
// bench --lod as users run it, on a tiny scene.
#include <map>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/cli/command.h"
#include "app/support/run_program.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "raster/scene/cloud_order.h"
#include "support/corpus.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::content_of;
using test::ProgramRun;
using testing::HasSubstr;
using testing::Not;

using CsvRow = std::map<std::string, std::string>;

std::vector<CsvRow> csv_rows(const std::filesystem::path& file) {
  std::istringstream text(content_of(file));
  std::string line;
  std::getline(text, line);
  const std::vector<std::string> names = separated(line);
  std::vector<CsvRow> rows;
  while (std::getline(text, line)) {
    const std::vector<std::string> cells = separated(line);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (i == 0) rows.emplace_back();
      rows.back()[names[i]] = cells.at(i);
    }
  }
  return rows;
}

class LodProgram : public testing::Test {
 protected:
  void SetUp() override {
    test::write_scene(cloud_, scene_);
    write_views(2);
  }

  void write_views(int count) const {
    std::vector<Camera> cameras;
    for (int i = 0; i < count; ++i) cameras.push_back(test::front_camera(96 + 16 * i, 72));
    test::write_cameras(cameras, folder_ / "cameras.json");
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  ProgramRun lod(std::vector<std::string> words) const {
    words.insert(words.begin(), {"bench", "--lod"});
    words.insert(words.end(), {"--backend", "cpu", "--frames", "1", "--warmup", "0"});
    return test::run_quadsplat(words);
  }

  TemporaryFolder folder_;
  GaussianCloud cloud_ = test::random_cloud(600, 1, 11);
  std::string scene_ = path("scene.ply");
};

TEST_F(LodProgram, every_method_has_a_row_per_view_distance_budget_and_share) {
  const ProgramRun run = lod({scene_, "--budgets", "10,100", "--out-dir", path("out")});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("# Levels of detail: scene, 600 Gaussians, 2 views, backend cpu"));
  EXPECT_THAT(run.out, HasSubstr("| far | 100 % | distance | 600 | inf | 1.0000 | 0.0000 | inf |"));
  EXPECT_EQ(content_of(folder_ / "out/lod.md"), "<!-- written by quadsplat bench -->\n" + run.out);
  const std::vector<CsvRow> rows = csv_rows(folder_ / "out/lod.csv");
  ASSERT_EQ(rows.size(), 2u * 3 * 2 * 2 * 3);  // views, distances, budgets, shares, methods
  std::map<std::string, int> gaussians;        // of the leaves in view
  for (CsvRow row : rows) {
    if (row["budget_percent"] == "100") {
      EXPECT_EQ(row["psnr"], "inf") << row["method"] << row["distance"];
      EXPECT_EQ(row["worst_block_psnr"], "inf");
      if (row["share_of"] == "in view")
        gaussians[row["camera"] + row["distance"]] = std::stoi(row["gaussians"]);
      continue;
    }
    EXPECT_LT(std::stod(row["psnr"]), 60);
    EXPECT_LE(std::stod(row["worst_block_psnr"]), std::stod(row["psnr"]));
    if (row["share_of"] == "all") {
      EXPECT_LE(std::stoi(row["gaussians"]), 60);
    }
  }
  for (CsvRow row : rows) {
    if (row["budget_percent"] != "10" || row["share_of"] != "in view") continue;
    EXPECT_LE(std::stoi(row["gaussians"]), 0.1 * gaussians[row["camera"] + row["distance"]] + 0.5);
  }
  // The program replaces its own report, and says what alters the scene.
  EXPECT_EQ(
      lod({scene_, "--out-dir", path("out"), "--budgets", "50", "--antialiased", "on"}).exit_code,
      kExitOk);
  EXPECT_THAT(content_of(folder_ / "out/lod.md"), HasSubstr("backend cpu, antialiased\n"));
  for (CsvRow row : csv_rows(folder_ / "out/lod.csv")) EXPECT_EQ(row["altered"], "antialiased");
}

TEST_F(LodProgram, levels_of_other_tools_have_their_own_budget) {
  write_views(1);
  test::write_scene(keep_largest(cloud_, 150), path("theirs.ply"));
  std::filesystem::create_directories(folder_ / "more");
  test::write_scene(cloud_, path("more/theirs.ply"));
  const ProgramRun run =
      lod({scene_, path("theirs.ply"), path("more/theirs.ply"), "--budgets", "50"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("| near | 25 % | " + path("theirs.ply") + " | 150 |"));
  EXPECT_THAT(run.out,
              HasSubstr("| near | 100 % | " + path("more/theirs.ply") + " | 600 | inf | 1.0000 |"));
}

TEST_F(LodProgram, a_tree_is_cut_and_its_leaves_can_be_the_scene) {
  const std::filesystem::path tree = test::committed_corpus() / "valid/lod_tree.rad";
  const GaussianCloud leaves = read_scene(tree, test::pool()).cloud;
  test::write_scene(leaves, path("leaves.ply"));
  Camera camera = test::front_camera(80, 60);
  camera.view_from_world[3].z = 6;
  test::write_cameras({camera}, path("cameras.json"));
  for (const std::vector<std::string>& scenes : std::vector<std::vector<std::string>>{
           {tree.string()}, {path("leaves.ply"), tree.string()}}) {
    std::vector<std::string> words = scenes;
    words.insert(words.end(), {"--cameras", path("cameras.json"), "--budgets", "10,50,100"});
    const ProgramRun run = lod(words);
    ASSERT_EQ(run.exit_code, kExitOk) << run.err;
    EXPECT_THAT(run.out, HasSubstr("16 Gaussians, 1 view,"));
    EXPECT_THAT(run.out, HasSubstr("| far | 10 % | " + tree.string() + " | 1 |"));
    EXPECT_THAT(run.out, HasSubstr("| far | 100 % | " + tree.string() + " | 16 | inf |"));
    EXPECT_THAT(run.err, Not(HasSubstr("leaves, and the scene")));
  }
  EXPECT_THAT(lod({scene_, tree.string(), "--budgets", "50"}).err,
              HasSubstr("it has 16 leaves, and the scene 600"));
}

TEST_F(LodProgram, a_tree_of_quadsplat_is_cut_by_its_errors_too) {
  const std::string tree = (test::committed_corpus() / "valid/lod_own.rad").string();
  Camera camera = test::front_camera(80, 60);
  camera.view_from_world[3].z = 6;
  test::write_cameras({camera}, path("cameras.json"));
  const ProgramRun run = lod({tree, "--cameras", path("cameras.json"), "--budgets", "1,100",
                              "--size", "800x600", "--out-dir", path("out")});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("| far | 1 % | " + tree + " by its errors | 1 |"));
  EXPECT_THAT(run.out, HasSubstr("| far | 100 % | " + tree + " by its errors | 24 | inf |"));
  EXPECT_THAT(run.out, HasSubstr("| far | 100 % | " + tree + " | 24 | inf |"));
  // Only cuts by errors that differ in several blocks have estimates to compare.
  int compared = 0;
  for (CsvRow row : csv_rows(folder_ / "out/lod.csv")) {
    if (row["error_rank_correlation"].empty()) continue;
    ++compared;
    EXPECT_TRUE(row["method"].ends_with("by its errors"));
    EXPECT_LT(std::stod(row["psnr"]), 100);
    EXPECT_GT(std::stod(row["error_rank_correlation"]), 0);
    EXPECT_GT(std::stod(row["error_ratio"]), 0.01);
    EXPECT_LT(std::stod(row["error_ratio"]), 100);
  }
  EXPECT_GE(compared, 1);
  // The plot has a point for each block.
  EXPECT_THAT(read_text_file(folder_ / "out/lod_errors.gp", 1 << 20),
              AllOf(HasSubstr("$near << END\n"), HasSubstr("$near with points")));
}

TEST_F(LodProgram, georeferenced_scenes_and_levels_are_in_one_place) {
  cloud_.origin = {500000, 4650000, 200};
  test::write_scene(cloud_, path("world.ply"));
  test::write_scene(keep_largest(cloud_, 300), path("half.ply"));
  Camera camera = test::front_camera(96, 72);
  camera.origin = cloud_.origin;
  test::write_cameras({camera}, path("cameras.json"));
  ASSERT_EQ(
      test::run_quadsplat({"lod", path("world.ply"), path("world.rad"), "--original"}).exit_code,
      kExitOk);
  const ProgramRun run =
      lod({path("world.ply"), path("half.ply"), path("world.ply"), path("world.rad"), "--budgets",
           "50,100", "--cameras", path("cameras.json")});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("| near | 100 % | " + path("world.rad") + " | 600 | inf |"));
  EXPECT_THAT(run.out, HasSubstr("| near | 100 % | " + path("world.ply") + " | 600 | inf |"));
}

TEST_F(LodProgram, what_it_cannot_measure_has_a_sentence) {
  const auto expect = [&](const std::vector<std::string>& words, const std::string& sentence) {
    const ProgramRun run = lod(words);
    EXPECT_EQ(run.exit_code, kExitUsage) << run.err;
    EXPECT_THAT(run.err, HasSubstr(sentence));
  };
  expect({scene_, "--rounds", "2"}, "bench: --lod measures levels of detail: it excludes --rounds");
  expect({scene_, "--load"}, "excludes --load");
  expect({scene_, "--psnr"}, "excludes --psnr");
  expect({scene_, "--scaling", "2"}, "excludes --scaling");
  expect({scene_, "--cull", "adr,quadbox"}, "bench: --lod draws in one mode");
  expect({scene_, "--budgets", "0"}, "--budgets: '0'");
  expect({scene_, "--budgets", "101"}, "--budgets: '101'");
  expect({scene_, "--budgets", "5,x"}, "--budgets: 'x'");
  Camera away = test::front_camera(96, 72);
  away.view_from_world[3].z = -1e6;
  test::write_cameras({away}, path("away.json"));
  expect({scene_, "--cameras", path("away.json")}, "the middle of its picture has no depth");
  const ProgramRun run = test::run_quadsplat({"bench", scene_, "--budgets", "5"});
  EXPECT_EQ(run.exit_code, kExitUsage);
  EXPECT_THAT(run.err, HasSubstr("--budgets needs --lod"));
}

}  // namespace
}  // namespace qs
