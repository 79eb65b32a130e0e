// SPDX-License-Identifier: MIT
//
// bench --flight as users run it, on tiny scenes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/measure/camera_path.h"
#include "app/support/run_program.h"
#include "io/bytes/replace_file.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::content_of;
using test::ProgramRun;
using testing::HasSubstr;

class FlightProgram : public testing::Test {
 protected:
  FlightProgram() { write_path("path.json", 3); }

  void write_path(const std::string& name, int count) const {
    std::vector<Keyframe> keyframes;
    for (int i = 0; i < count; ++i) {
      Camera camera = test::front_camera(96, 72);
      camera.view_from_world[3].x = 0.2 * i;
      keyframes.push_back({0.3 * i, camera});
    }
    write_text(folder_ / name, format_camera_path(keyframes));
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  // Writes a scene and its tree.
  std::string tree(std::size_t count) const {
    test::write_scene(test::random_cloud(count, 0, 5), path("scene.ply"));
    const ProgramRun run = test::run_quadsplat({"lod", path("scene.ply"), path("tree.rad")});
    EXPECT_EQ(run.exit_code, kExitOk) << run.err;
    return path("tree.rad");
  }

  ProgramRun fly(std::vector<std::string> words) const {
    words.insert(words.begin(), {"bench", "--flight"});
    words.insert(words.end(), {"--backend", "cpu"});
    return test::run_quadsplat(words);
  }

  TemporaryFolder folder_;
};

TEST_F(FlightProgram, a_tree_flies_with_its_cuts_at_every_pace) {
  const std::string scene = tree(45'000);  // two pages
  const ProgramRun run = fly(
      {scene, "--camera-path", path("path.json"), "--budget", "3000", "--out-dir", path("out")});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("# Flight: tree, 96 x 72, backend cpu"));
  EXPECT_EQ(content_of(folder_ / "out/flight.md"),
            "<!-- written by quadsplat bench -->\n" + run.out);
  const auto json = nlohmann::json::parse(content_of(folder_ / "out/flight.json"));
  ASSERT_EQ(json["flights"].size(), 3u);
  const char* const paces[] = {"walk", "drive", "jump"};
  const double seconds[] = {0.6, 0.06, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& flight = json["flights"][i];
    EXPECT_EQ(flight["pace"], paces[i]);
    EXPECT_GE(flight["seconds"], seconds[i]);
    EXPECT_GT(flight["frames"], 0);
    EXPECT_LE(flight["frames"].get<double>(), 2 + 60 * flight["seconds"].get<double>());
    EXPECT_GT(flight["frame_ms"]["p50"], 0);
    EXPECT_GE(flight["with_uploads_ms"]["p99"], flight["with_uploads_ms"]["p50"]);
    EXPECT_GE(flight["behind_percent"]["p50"], 0);
    EXPECT_LE(flight["behind_percent"]["p99"], 100);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& popping = json["flights"][i]["popping_percent"];
    EXPECT_GE(popping["p50"], 0);
    EXPECT_LE(popping["p99"], 100);
  }
  EXPECT_TRUE(json["flights"][2]["popping_percent"].is_null());
  EXPECT_GT(json["flights"][0]["cut_ms"]["p50"], 0);
  EXPECT_LT(json["flights"][2]["sharp_after_s"]["p99"], 5);
  EXPECT_EQ(json["flights"][2]["pages_read"], 1);
  EXPECT_GT(json["flights"][2]["megabytes_read"], 0.1);
  // The walk and the drive begin when the first view is complete.
  EXPECT_EQ(json["flights"][0]["pages_read"], 0);
  EXPECT_EQ(json["flights"][0]["frames_with_missing_pages"], 0);
}

TEST_F(FlightProgram, nothing_pops_if_all_leaves_are_drawn) {
  const std::string scene = tree(2'000);
  ASSERT_EQ(
      fly({scene, "--camera-path", path("path.json"), "--lod-error", "0", "--out-dir", path("out")})
          .exit_code,
      kExitOk);
  const auto json = nlohmann::json::parse(content_of(folder_ / "out/flight.json"));
  for (const auto& flight : json["flights"]) EXPECT_EQ(flight["behind_percent"]["p99"], 0);
  EXPECT_EQ(json["flights"][0]["popping_percent"]["p99"], 0);
}

TEST_F(FlightProgram, a_whole_scene_has_no_cuts) {
  test::write_scene(test::random_cloud(500, 1, 5), path("scene.ply"));
  const ProgramRun run = fly({path("scene.ply"), "--camera-path", path("path.json"), "--out-dir",
                              path("out"), "--size", "40x30"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("40 x 30"));
  EXPECT_THAT(run.out, HasSubstr("| walk | 0.6"));
  const auto json = nlohmann::json::parse(content_of(folder_ / "out/flight.json"));
  for (const auto& flight : json["flights"]) EXPECT_TRUE(flight["cut_ms"].is_null());
}

TEST_F(FlightProgram, refusals_name_the_option) {
  test::write_scene(test::random_cloud(50, 0, 5), path("scene.ply"));
  write_path("one.json", 1);
  write_text(folder_ / "bad.json", "[{}]");
  const std::string scene = path("scene.ply"), along = path("path.json");
  const struct {
    std::vector<std::string> words;
    const char* sentence;
  } cases[] = {
      {{scene}, "--flight flies along a --camera-path"},
      {{scene, "--camera-path", along, "--lod"}, "it excludes --lod"},
      {{scene, scene, "--camera-path", along}, "name one scene"},
      {{scene, "--camera-path", along, "--cull", "all"}, "choose one with --cull"},
      {{scene, "--camera-path", along, "--frames", "3"}, "it excludes --frames"},
      {{scene, "--camera-path", along, "--path-steps", "3"}, "it excludes --path-steps"},
      {{scene, "--camera-path", along, "--psnr"}, "it excludes --psnr"},
      {{scene, "--camera-path", along, "--scaling", "2"}, "--scaling"},
      {{scene, "--camera-path", along, "--rounds", "2"}, "it excludes --rounds"},
      {{scene, "--camera-path", path("one.json")}, "at least two cameras"},
      {{scene, "--camera-path", path("bad.json")}, "bad.json: keyframe 0"},
      {{scene, "--camera-path", path("none.json")}, "none.json"},
  };
  for (const auto& [words, sentence] : cases) {
    const ProgramRun run = fly(words);
    EXPECT_NE(run.exit_code, kExitOk) << sentence;
    EXPECT_THAT(run.err, HasSubstr(sentence));
  }
}

}  // namespace
}  // namespace qs
