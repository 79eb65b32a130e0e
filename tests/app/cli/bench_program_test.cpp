// SPDX-License-Identifier: MIT
//
// bench and zoom as users run them, on a tiny scene.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/report/bench_report.h"
#include "app/support/run_program.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/scene/writer.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using nlohmann::json;
using test::ProgramRun;
using test::run_quadsplat;
using testing::HasSubstr;
using testing::Not;

BenchReport read_bench_json(const std::filesystem::path& path) {
  return parse_bench_report(parse_own_json(read_text_file(path, 1 << 26)));
}

class BenchProgram : public testing::Test {
 protected:
  void SetUp() override {
    test::write_scene(test::random_cloud(300, 1, 11), scene_);
    std::vector<Camera> cameras;
    for (int i = 0; i < 2; ++i) cameras.push_back(test::front_camera(64 + 16 * i, 48));
    test::write_cameras(cameras, folder_ / "cameras.json");
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  ProgramRun bench(const std::string& out, std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"bench", scene_,      "--frames", "2",         "--warmup",
                                      "1",     "--backend", "cpu",      "--out-dir", path(out)};
    words.insert(words.end(), more.begin(), more.end());
    return run_quadsplat(words);
  }

  ProgramRun zoom(std::vector<std::string> words) const {
    words.insert(words.begin(), "zoom");
    words.insert(words.end(), {"--frames", "1", "--warmup", "0", "--backend", "cpu"});
    return run_quadsplat(words);
  }

  TemporaryFolder folder_;
  std::string scene_ = path("scene.ply");
};

TEST_F(BenchProgram, bench_writes_one_row_per_scene_camera_and_mode) {
  const ProgramRun run = bench("out", {"--psnr", "--rounds", "2"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("| `quadbox` |"));
  const BenchReport report = read_bench_json(folder_ / "out/bench.json");
  ASSERT_EQ(report.rows.size(), 12u);
  std::set<std::string> keys;
  for (const BenchRow& row : report.rows) {
    keys.insert(row.scene + row.camera + row.mode);
    EXPECT_GT(row.ms_median, 0);
    EXPECT_GT(row.blend_ms, 0);
    EXPECT_GT(row.pairs, 0u);
    EXPECT_TRUE(row.psnr_vs_reference.has_value());
    ASSERT_TRUE(row.false_positives.has_value());
    EXPECT_LT(*row.false_positives, row.pairs);
    EXPECT_DOUBLE_EQ(*row.false_positive_share,
                     static_cast<double>(*row.false_positives) / static_cast<double>(row.pairs));
  }
  EXPECT_EQ(keys.size(), 12u);
  EXPECT_THAT(report.scenes[0]["hash"].get<std::string>(), HasSubstr("crc32:"));
  for (const char* file : {"bench.csv", "bench.md", "fps.gp", "stages.gp", "pairs.gp"})
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / file)) << file;
}

TEST_F(BenchProgram,
       a_view_measured_three_times_agrees_within_three_per_cent_or_one_warning_tells) {
  const ProgramRun run = bench("out", {"--rounds", "3"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  const std::vector<BenchRow> rows = read_bench_json(folder_ / "out/bench.json").rows;
  const auto noisy = std::count_if(rows.begin(), rows.end(), [](const BenchRow& row) {
    return row.round_spread > 0.03 || std::abs(row.drift) > 0.03;
  });
  if (noisy == 0) {
    EXPECT_THAT(run.err, Not(HasSubstr("noisy")));
  } else {
    EXPECT_THAT(run.err, HasSubstr(fmt::format("warning: {} of 12 rows are noisy", noisy)));
    EXPECT_EQ(run.err.find("noisy"), run.err.rfind("noisy"));
  }
}

TEST_F(BenchProgram, two_scenes_of_one_name_are_two_scenes) {
  std::filesystem::create_directories(folder_ / "other");
  std::filesystem::copy(scene_, folder_ / "other");
  const ProgramRun run = bench("out", {path("other/scene.ply"), "--cull", "quadbox"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("\n## scene\n"));
  EXPECT_THAT(run.out, HasSubstr("\n## scene (2)\n"));
}

TEST_F(BenchProgram, scaling_measures_growing_grids_of_one_scene) {
  const ProgramRun run = bench("out", {"--scaling", "2", "--cull", "quadbox", "--size", "64x48"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  const BenchReport report = read_bench_json(folder_ / "out/bench.json");
  ASSERT_EQ(report.rows.size(), 2u);
  EXPECT_EQ(report.rows[0].gaussians, 300u);
  EXPECT_EQ(report.rows[1].gaussians, 1200u);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/scaling.gp"));
  EXPECT_THAT(run.err, Not(HasSubstr("gnuplot failed")));
}

TEST_F(BenchProgram, holdout_measures_the_test_views_and_adds_the_paper_s_fps) {
  std::vector<Camera> cameras;
  for (const char* name : {"c", "a", "e", "b", "d"}) {
    cameras.push_back(test::front_camera(64, 48));
    cameras.back().name = name;
  }
  test::write_cameras(cameras, folder_ / "cameras.json");
  const ProgramRun run = bench("out", {"--holdout", "2", "--cull", "adr,quadbox"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("| FPS | FPS (paper) |"));
  std::vector<std::string> views;  // a, c, e
  for (const BenchRow& row : read_bench_json(folder_ / "out/bench.json").rows) {
    EXPECT_GT(row.ms_paper.value(), 0);
    if (row.mode == "adr") views.push_back(row.camera);
  }
  EXPECT_THAT(views, testing::ElementsAre("1", "0", "2"));
  const auto report = parse_own_json(read_text_file(folder_ / "out/bench.json", 1 << 26));
  EXPECT_EQ(report["fps_paper"].size(), 4u);  // of the scene and of the set
  const ProgramRun part =
      bench("part", {"--holdout", "2", "--cull", "adr,quadbox", "--shard", "2/2"});
  ASSERT_EQ(part.exit_code, kExitOk) << part.err;
  for (const BenchRow& row : read_bench_json(folder_ / "part/bench.json").rows) {
    EXPECT_EQ(row.camera, "0");
    EXPECT_TRUE(row.ms_paper);
  }
  EXPECT_THAT(bench("no", {"--holdout", "2", "--camera-index", "0"}).err,
              HasSubstr("bench: --holdout chooses the views: it excludes --camera-index"));
}

TEST_F(BenchProgram, bench_follows_a_camera_path) {
  const ProgramRun run = bench(
      "out", {"--camera-path", path("cameras.json"), "--path-steps", "3", "--cull", "quadbox"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_EQ(read_bench_json(folder_ / "out/bench.json").rows.size(), 3u);
}

TEST_F(BenchProgram, a_replayed_zoom_has_equal_counts_and_a_changed_count_ends_with_4) {
  const ProgramRun first =
      zoom({scene_, "--target", "0,0,4", "--steps", "4", "--out-dir", path("zoom")});
  ASSERT_EQ(first.exit_code, kExitOk) << first.err;
  for (const char* file : {"zoom.csv", "zoom_fps.gp", "step_0000.png", "step_0003.png"})
    EXPECT_TRUE(std::filesystem::exists(folder_ / "zoom" / file)) << file;
  EXPECT_THAT(first.err, Not(HasSubstr("gnuplot failed")));
  const ProgramRun again = zoom({"--replay", path("zoom")});
  EXPECT_EQ(again.exit_code, kExitOk) << again.err;
  EXPECT_THAT(again.out, HasSubstr("all pair counts are equal"));

  const std::filesystem::path file = folder_ / "zoom/zoom.json";
  json bundle = parse_json(read_text_file(file, 1 << 26), "test");
  ASSERT_EQ(bundle["rows"].size(), 24u);
  bundle["rows"][5]["pairs"] = bundle["rows"][5]["pairs"].get<int>() + 1;
  std::ofstream(file) << bundle;
  const ProgramRun changed = zoom({"--replay", path("zoom")});
  EXPECT_EQ(changed.exit_code, kExitComparison);
  EXPECT_THAT(changed.err, HasSubstr("step 0, exact"));
}

}  // namespace
}  // namespace qs
