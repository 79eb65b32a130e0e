// SPDX-License-Identifier: MIT
//
// quadsplat measure on a wall at a known distance.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/support/program_in_folder.h"

namespace qs {
namespace {

using test::ProgramRun;
using testing::AllOf;
using testing::HasSubstr;

// The scene is the wall z = 4 of flat Gaussians, with a hole at the left.
class MeasuredWall : public test::ProgramInFolder {
 protected:
  void edit(GaussianCloud& cloud) override {
    constexpr int kColumns = 20, kRows = 15;
    ASSERT_EQ(cloud.size(), std::size_t{kColumns * kRows});
    for (int i = 0; i < kColumns * kRows; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const float x = static_cast<float>(i % kColumns) - 9.5f;
      const float y = static_cast<float>(i / kColumns) - 7;
      cloud.positions[at] = {0.3f * x, 0.3f * y, 4};
      cloud.log_scales[at] = {std::log(0.3f), std::log(0.3f), -INFINITY};
      cloud.rotations[at] = {1, 0, 0, 0};
      cloud.opacity_logits[at] = x < -4 ? -9.0f : 5.0f;
    }
  }
  nlohmann::json measured(const std::string& options) const {
    const ProgramRun done = run("measure @scene.ply --json - --backend cpu " + options);
    EXPECT_EQ(done.exit_code, kExitOk) << done.err;
    return nlohmann::json::parse(done.out);
  }
  // World units per pixel on the wall.
  double pixel() const { return 4 / test::front_camera(32, 24).focal_px.x; }
  double row() const { return 4 / test::front_camera(32, 24).focal_px.y; }
};

TEST_F(MeasuredWall, has_the_distances_and_angles_of_its_points) {
  const auto json = measured("--pixels 16,12 26,12 26,18 --up 0,-1,0");
  EXPECT_EQ(json["unit"], "units");
  ASSERT_EQ(json["points"].size(), 3u);
  for (const auto& point : json["points"]) {
    EXPECT_NEAR(point["position"][2], 4, 1e-5);
    EXPECT_LT(point["along"], 1e-5);
    EXPECT_NEAR(point["across"], pixel() / std::sqrt(12), 0.01);
    EXPECT_EQ(point["soft"], false);
  }
  ASSERT_EQ(json["distances"].size(), 2u);
  EXPECT_NEAR(json["distances"][0]["length"], 10 * pixel(), 1e-5);
  EXPECT_NEAR(json["distances"][1]["length"], 6 * row(), 1e-5);
  EXPECT_NEAR(json["distances"][0]["height"], 0, 1e-5);
  EXPECT_NEAR(json["distances"][1]["height"], -6 * row(), 1e-5);
  EXPECT_NEAR(json["angles"][0]["degrees"], 90, 1e-3);
  EXPECT_FALSE(json.contains("steps"));
}

TEST_F(MeasuredWall, is_scaled_to_a_known_length_and_turned_to_the_ground) {
  const auto json = measured("--pixels 16,12 26,12 26,18 --known 5 --unit m --level");
  EXPECT_EQ(json["unit"], "m");
  EXPECT_NEAR(json["distances"][0]["length"], 5, 1e-9);
  EXPECT_NEAR(json["distances"][1]["length"], 3 * row() / pixel(), 1e-4);
  ASSERT_EQ(json["steps"].size(), 2u);
  EXPECT_NEAR(json["steps"][0]["factor"], 5 / (10 * pixel()), 1e-5);
  EXPECT_EQ(json["steps"][0]["unit"], "m");
  // The wall's side of the camera, -z, becomes up, -y: a quarter turn about x.
  const auto turn = json["steps"][1]["rotation"];
  EXPECT_NEAR(std::abs(turn[0].get<double>()), std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(turn[3], std::sqrt(0.5), 1e-9);
  // convert carries both steps out: the wall becomes the floor y = const below the camera.
  std::ofstream(folder_ / "a.edits.json")
      << nlohmann::json{{"version", 1}, {"steps", json["steps"]}}.dump();
  ASSERT_EQ(run("convert @scene.ply @out.ply --edits @a.edits.json").exit_code, kExitOk);
  const auto cloud = test::read_scene(folder_ / "out.ply").cloud;
  for (const glm::vec3& position : cloud.positions)
    EXPECT_NEAR(position.y, 4 * 5 / (10 * pixel()), 1e-3);
}

TEST_F(MeasuredWall, takes_scale_and_ground_from_a_file_of_measures) {
  std::ofstream(folder_ / "a.measures.json")
      << R"({"version": 1, "scale": {"factor": 2, "unit": "cm"},
             "ground": {"point": [0, 0, 4], "up": [1, 0, 0]}, "lines": []})";
  const auto json = measured("--pixels 16,12 26,12 --measures @a.measures.json");
  EXPECT_EQ(json["unit"], "cm");
  EXPECT_NEAR(json["distances"][0]["length"], 20 * pixel(), 1e-4);
  EXPECT_NEAR(json["distances"][0]["height"], 20 * pixel(), 1e-4);
  std::ofstream(folder_ / "b.measures.json")
      << R"({"version": 1, "scene": {"gaussians": 3}, "lines": []})";
  const ProgramRun refused = run("measure @scene.ply --pixels 1,1 --measures @b.measures.json");
  EXPECT_EQ(refused.exit_code, kExitInput);
  EXPECT_THAT(refused.err, HasSubstr("b.measures.json: it is of a scene of 3 Gaussians"));
}

TEST_F(MeasuredWall, has_no_point_in_a_hole) {
  const auto json = measured("--pixels 1,12 16,12");
  EXPECT_FALSE(json["points"][0].contains("position"));
  EXPECT_TRUE(json["distances"].empty());
  const ProgramRun text = run("measure @scene.ply --backend cpu --pixels 1,12 16,12 26,12");
  EXPECT_THAT(text.out,
              AllOf(HasSubstr("point 1 at pixel 1,12: no surface"), HasSubstr("2 to 3: ")));
}

TEST_F(MeasuredWall, refuses_what_it_cannot_measure) {
  const std::pair<const char*, const char*> wrong[] = {
      {"--pixels 16", "--pixels: '16' is not X,Y"},
      {"--pixels 1,2 32,0", "there is no pixel 32,0: the picture is 32 x 24"},
      {"--pixels 16,12 --known 3", "--known: needs 2 points"},
      {"--pixels 16,12 16,12 --known 3", "--known: both points are the same"},
      {"--pixels 16,12 1,12 --known 3", "--known: pixel 1,12 shows no surface"},
      {"--pixels 16,12 20,12 24,12 --level", "--level: the points lie on a line"},
      {"--pixels 16,12 --unit m", "--unit: needs --known"},
      {"--pixels 16,12 20,12 --known 3 --measures @a.measures.json", "choose one"},
      {"--pixels 16,12 --cull 3dgs,exact", "choose one camera and one mode"}};
  for (const auto& [options, problem] : wrong) {
    const ProgramRun refused = run("measure @scene.ply --backend cpu " + std::string(options));
    EXPECT_NE(refused.exit_code, kExitOk) << options;
    EXPECT_THAT(refused.err, HasSubstr(problem));
  }
}

}  // namespace
}  // namespace qs
