// SPDX-License-Identifier: MIT
//
// Merged shards of bench, eval and render equal the report of a single run, except for times.
#include "app/report/merge.h"

#include <array>
#include <fstream>
#include <ostream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/support/run_program.h"
#include "base/error.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "io/scene/writer.h"
#include "raster/api/renderer.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using nlohmann::ordered_json;
using test::ProgramRun;
using test::run_quadsplat;
using testing::HasSubstr;

constexpr int kViews = 5;

// A command that takes --shard, and the report that it writes to a folder.
struct Sharded {
  const char* command;
  const char* file;
  const char* rows;
  std::vector<std::string> words;  ///< FOLDER is replaced by the report's folder
};

void PrintTo(const Sharded& sharded, std::ostream* out) { *out << sharded.command; }

const Sharded kSharded[] = {
    {"bench",
     "bench.json",
     "rows",
     {"--frames", "2", "--warmup", "0", "--cull", "3dgs,quadbox", "--out-dir", "FOLDER"}},
    {"eval",
     "eval.json",
     "views",
     {"--images", "IMAGES", "--cull", "3dgs,quadbox", "--out-dir", "FOLDER"}},
    {"render", "stats.json", "frames", {"--all-cameras", "--stats", "FOLDER/stats.json"}},
};

class Merge : public testing::TestWithParam<Sharded> {
 protected:
  void SetUp() override {
    const GaussianCloud cloud = test::random_cloud(300, 1, 11);
    test::write_scene(cloud, folder_ / "scene.ply");
    std::filesystem::create_directories(folder_ / "images");
    std::vector<Camera> cameras;
    for (int i = 0; i < kViews; ++i) {
      Camera camera = test::front_camera(64, 48);
      camera.view_from_world[3].x = 0.1 * i;
      camera.name = "view" + std::to_string(i);
      cameras.push_back(camera);
      Image photograph(64, 48, 3);
      photograph.values.assign(photograph.values.size(), 0.1f * static_cast<float>(i));
      write_image(photograph, folder_ / ("images/" + camera.name + ".ppm"));
    }
    test::write_cameras(cameras, folder_ / "cameras.json");
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  // Runs the command so that it writes its report to the folder.
  void measure(const std::string& name, const std::vector<std::string>& more = {}) const {
    std::filesystem::create_directories(folder_ / name);
    std::vector<std::string> words = {GetParam().command, path("scene.ply"), "--backend", "cpu"};
    for (std::string word : GetParam().words) {
      if (word.starts_with("FOLDER")) word.replace(0, 6, path(name));
      words.push_back(word == "IMAGES" ? path("images") : word);
    }
    words.insert(words.end(), more.begin(), more.end());
    const ProgramRun run = run_quadsplat(words);
    ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  }

  ordered_json report(const std::string& name) const {
    return parse_own_json(read_text_file(folder_ / name / GetParam().file, 1 << 26));
  }

  TemporaryFolder folder_;
};

// The report without times and the command line.
ordered_json timeless(const ordered_json& json) {
  if (!json.is_structured()) return json;
  ordered_json result = json.is_array() ? ordered_json::array() : ordered_json::object();
  for (const auto& [key, value] : json.items()) {
    const bool time = key.starts_with("ms_") || key.ends_with("_ms") || key == "fps_median" ||
                      key == "drift" || key == "utc" || key == "flags" ||
                      key.starts_with("ratio_") || key == "ratio";
    if (json.is_array()) result.push_back(timeless(value));
    if (json.is_object() && !time) result[key] = timeless(value);
  }
  return result;
}

TEST_P(Merge, two_shards_equal_one_run_times_aside) {
  measure("whole");
  measure("one", {"--shard", "1/2"});
  measure("two", {"--shard=2/2"});
  EXPECT_LT(report("one")[GetParam().rows].size(), report("whole")[GetParam().rows].size());
  const ProgramRun run =
      run_quadsplat({"merge", path("two"), path("one"), "--out-dir", path("merged")});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_THAT(run.err, testing::Not(HasSubstr("missing")));
  EXPECT_EQ(timeless(report("merged")), timeless(report("whole")));
  EXPECT_THAT(report("merged")["environment"].dump(), testing::Not(HasSubstr("--shard")));
}

TEST_P(Merge, tells_which_views_no_shard_measured_and_refuses_rows_measured_twice) {
  measure("one", {"--shard", "1/2"});
  measure("empty", {"--shard", "9/9"});
  const ProgramRun holes =
      run_quadsplat({"merge", path("one"), path("empty"), "--out-dir", path("merged")});
  EXPECT_EQ(holes.exit_code, kExitOk) << holes.err;
  EXPECT_THAT(holes.err, HasSubstr("2 of 5 views are missing: 1, 3\n"));
  const ProgramRun twice =
      run_quadsplat({"merge", path("one"), path("one"), "--out-dir", path("merged"), "--mixed"});
  EXPECT_EQ(twice.exit_code, kExitInput);
  EXPECT_THAT(twice.err, HasSubstr("view 0, mode "));
}

TEST_P(Merge, refuses_another_device_unless_told) {
  measure("one", {"--shard", "1/2"});
  measure("two", {"--shard", "2/2"});
  ordered_json other = report("two");
  other["environment"]["cpu"] = "another CPU";
  std::ofstream(folder_ / "two" / GetParam().file) << other;
  const std::vector<std::string> words = {"merge",     path("one"), path("two"),
                                          "--out-dir", path("all"), "--mixed"};
  const ProgramRun strict = run_quadsplat({words.begin(), words.end() - 1});
  EXPECT_EQ(strict.exit_code, kExitInput);
  EXPECT_THAT(strict.err, HasSubstr("differ in their device"));
  const ProgramRun mixed = run_quadsplat(words);
  ASSERT_EQ(mixed.exit_code, kExitOk) << mixed.err;
  EXPECT_THAT(report("all")["environment"]["gpu"], HasSubstr(" + another CPU"));
}

TEST_P(Merge, folders_without_a_report_and_damaged_reports_are_told) {
  measure("one", {"--shard", "1/2"});
  std::filesystem::create_directories(folder_ / "nothing");
  const auto merge = [&](const std::string& one, const std::string& two) {
    return run_quadsplat({"merge", path(one), path(two), "--out-dir", path("all")});
  };
  EXPECT_THAT(merge("nothing", "nothing").err, HasSubstr("holds none of bench.json"));
  EXPECT_THAT(merge("one", "nothing").err, HasSubstr(path("nothing") + ": holds no "));
  for (const char* text : {"{}", "[1]", "{\"rows\": 3}", "nonsense"}) {
    std::ofstream(folder_ / "nothing" / GetParam().file) << text;
    const ProgramRun run = merge("one", "nothing");
    EXPECT_EQ(run.exit_code, kExitInput) << text;
    EXPECT_THAT(run.err, HasSubstr("is not a report that can be merged"));
  }
}

INSTANTIATE_TEST_SUITE_P(Commands, Merge, testing::ValuesIn(kSharded),
                         [](const auto& sharded) { return std::string(sharded.param.command); });

ReportPart part(const char* commit, const char* hash, int view, const char* pipeline = "fast") {
  return {commit,
          {{"environment",
            {{"cpu", "some CPU"}, {"backend", "cpu"}, {"commit", commit}, {"pipeline", pipeline}}},
           {"scene", {{"hash", hash}}},
           {"view_count", 20},
           {"rows", ordered_json::array({{{"view", view}, {"mode", "exact"}}})}}};
}

TEST(MergeReports, refuse_other_commits_scenes_and_pipelines_unless_mixed_which_names_all) {
  for (const ReportPart& other :
       {part("def", "1", 2), part("abc", "2", 2), part("abc", "1", 2, "classic")}) {
    const std::array parts = {part("abc", "1", 0), other};
    EXPECT_THROW(merge_reports(parts, "rows", false), Error);
    EXPECT_EQ(merge_reports(parts, "rows", true)["rows"].size(), 2u);
  }
  const std::array parts = {part("abc", "1", 0), part("def", "1", 2)};
  EXPECT_EQ(merge_reports(parts, "rows", true)["environment"]["commit"], "abc + def");
}

TEST(MergeReports, refuse_another_baseline) {
  std::array parts = {part("abc", "1", 0), part("abc", "1", 2)};
  parts[0].report["environment"]["baseline"] = "adr";
  EXPECT_THROW(merge_reports(parts, "rows", false), Error);
  EXPECT_EQ(merge_reports(parts, "rows", true)["environment"]["baseline"], "adr");
  parts[1].report["environment"]["baseline"] = "adr";
  EXPECT_EQ(merge_reports(parts, "rows", false)["rows"].size(), 2u);
}

TEST(MergeReports, a_long_list_of_missing_views_is_cut) {
  const std::array parts = {part("abc", "1", 3)};
  EXPECT_EQ(missing_views(merge_reports(parts, "rows", false), "rows"),
            "19 of 20 views are missing: 0, 1, 2, 4, 5, 6, 7, 8, ..");
}

}  // namespace
}  // namespace qs
