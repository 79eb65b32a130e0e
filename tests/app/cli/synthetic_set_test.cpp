// SPDX-License-Identifier: MIT
// scripts/synthetic_set as users run it.
#include <algorithm>
#include <cstdlib>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/scene_box.h"
#include "app/session/session.h"
#include "app/support/run_program.h"
#include "learn/run/data_set.h"
#include "support/paths.h"
#include "support/pool.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::ProgramRun;

class SyntheticSet : public testing::Test {
 protected:
  void SetUp() override {
    if (test::run_program("python3", {"--version"}).exit_code == 127)
      GTEST_SKIP() << "python3 is not installed";
    setenv("PROGRAM", test::quadsplat_program().c_str(), 1);
  }
  void TearDown() override { unsetenv("PROGRAM"); }

  static ProgramRun make(std::vector<std::string> words) {
    words.insert(words.begin(), test::source_path("scripts/synthetic_set").string());
    return test::run_program("python3", words);
  }
  const std::string scene_ = test::source_path("assets/plush.ply").string();
  TemporaryFolder folder_;
};

TEST_F(SyntheticSet, has_pictures_of_the_scene_from_all_around) {
  const std::string out = (folder_ / "set").string();
  const ProgramRun run = make({scene_, out, "--views", "6", "--size", "64x48"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, "synthetic_set: 6 views of plush.ply, 64x48, in " + out + "\n");
  train::DataOptions options;
  options.data = out;
  options.holdout = 0;
  const train::DataSet data = read_data_set(options, test::pool());
  ASSERT_EQ(data.training.size(), 6u);
  const SceneBox core = core_box(load_scene(scene_, test::pool()).cloud);
  const float longest = std::max({core.size().x, core.size().y, core.size().z});
  std::set<std::vector<std::uint8_t>> pictures;
  for (const train::PhotographView& view : data.training) {
    EXPECT_EQ(view.camera.width, 64);
    EXPECT_EQ(view.camera.height, 48);
    const glm::dvec3 seen = view.camera.view_from_world * glm::dvec4(core.center(), 1);
    EXPECT_NEAR(seen.x, 0, 1e-4);
    EXPECT_NEAR(seen.y, 0, 1e-4);
    EXPECT_NEAR(seen.z, 1.3 * longest, 1e-3);
    const std::size_t middle = 3 * (24 * 64 + 32);
    EXPECT_GT(view.rgb.at(middle) + view.rgb.at(middle + 1) + view.rgb.at(middle + 2), 0);
    pictures.insert(view.rgb);
  }
  EXPECT_EQ(pictures.size(), 6u);
}

TEST_F(SyntheticSet, is_not_made_of_bad_words) {
  const std::string out = (folder_ / "set").string();
  const auto error_of = [&](const std::string& option, const std::string& value) {
    const ProgramRun run = make({scene_, out, option, value});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_EQ(run.out, "");
    return run.err;
  };
  EXPECT_EQ(error_of("--size", "800"),
            "synthetic_set: --size: '800' is not a size such as 800x600\n");
  EXPECT_EQ(error_of("--views", "0"), "synthetic_set: --views: 0 is not more than 0\n");
  EXPECT_EQ(error_of("--points", "0"), "synthetic_set: --points: 0 is not more than 0\n");
  EXPECT_EQ(error_of("--fov", "180"), "synthetic_set: --fov: 180 is not between 0 and 180\n");
  EXPECT_EQ(error_of("--elevation", "91"),
            "synthetic_set: --elevation: 91 is not more than 0 and at most 90\n");
  EXPECT_EQ(error_of("--distance", "0"), "synthetic_set: --distance: 0 is not more than 0\n");
  EXPECT_THAT(make({scene_}).err, testing::HasSubstr("required: out\n"));
  EXPECT_THAT(make({"--help"}).err, testing::HasSubstr("scripts/synthetic_set SCENE OUT"));
  EXPECT_FALSE(std::filesystem::exists(out));
  EXPECT_THAT(error_of("--cameras", "/none.json"), testing::HasSubstr("/none.json"));
}

}  // namespace
}  // namespace qs
