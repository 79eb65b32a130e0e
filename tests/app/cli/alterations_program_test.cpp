// SPDX-License-Identifier: MIT
//
// Every output of every command that measures or draws says how the scene was altered, and says
// nothing if it was not.
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/support/program_in_folder.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

namespace fs = std::filesystem;
using test::ProgramRun;
using test::run_quadsplat;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

class AlteredOutputs : public test::ProgramInFolder {
 protected:
  void edit(GaussianCloud& cloud) override {
    cloud.log_scales[9] = glm::vec3(9);  // larger than the scene
    cloud.opacity_logits[9] = -4;
  }
};

struct AlteredCommand {
  std::string line;
  std::vector<std::string> outputs;  // "stdout", "stderr" or files below "out"
};

const std::string kQuick = " --cull 3dgs,quadbox --backend cpu --threads 1";

const AlteredCommand kAlteredCommands[] = {
    {"bench @scene.ply --frames 6 --warmup 0 --out-dir @out" + kQuick,
     {"stdout", "bench.json", "bench.csv", "bench.md", "ratios.csv", "fps.gp", "stages.gp",
      "pairs.gp"}},
    {"zoom @scene.ply --steps 2 --frames 2 --warmup 0 --out-dir @out" + kQuick,
     {"zoom.json", "zoom.csv", "zoom_fps.gp", "zoom_ms.gp", "zoom_pairs.gp", "step_0000.png"}},
    {"zoom @scene.ply --steps 2 --frames 2 --warmup 0" + kQuick, {"stdout"}},
    {"render @scene.ply --output @out/f.png --stats @out/stats.json" + kQuick,
     {"stdout", "stderr", "f_3dgs.png", "stats.json"}},
    {"render @scene.ply --heatmap pairs --output @out/f.png --backend cpu", {"stderr", "f.png"}},
    {"eval @scene.ply --images @images --out-dir @out --save @out/saved" + kQuick,
     {"stdout", "eval.csv", "eval.json", "saved/view_view_quadbox.png"}},
    {"film @scene.ply --seconds 0.1 --size 32x24 --output @out/film" + kQuick,
     {"stderr", "film/frame_00000.png"}},
    {"inspect @scene.ply --backend cpu --output @out/why.png", {"stdout", "why.png"}},
    {"compare @scene.ply --output @out/sheet.png --backend cpu", {"stdout", "sheet.png"}},
    {"report @scene.ply --output @out/page.html", {"page.html"}},
};

TEST_F(AlteredOutputs, say_every_alteration_and_are_silent_without_one) {
  const std::pair<const char*, const char*> alterations[] = {
      {"", ""},
      {" --splat-scale 0.5 --skip-huge",
       "splat scale 0.5, edited: 1 step, 299 of 300 Gaussians, crc32:"},
      {" --splat-scale 8 --style points", "splat scale 8, drawn as points"},
  };
  for (const auto& [options, words] : alterations) {
    for (const AlteredCommand& command : kAlteredCommands) {
      SCOPED_TRACE(command.line + options);
      fs::remove_all(folder_ / "out");
      fs::create_directories(folder_ / "out");
      const ProgramRun done = run(command.line + options);
      ASSERT_EQ(done.exit_code, kExitOk) << done.err;
      for (const std::string& output : command.outputs) {
        const std::string text = output == "stdout"   ? done.out
                                 : output == "stderr" ? done.err
                                                      : test::content_of(folder_ / "out" / output);
        ASSERT_NE(text, "") << output;
        if (*words != '\0') {
          EXPECT_THAT(text, HasSubstr(words)) << output;
        } else {
          EXPECT_THAT(text, Not(AnyOf(HasSubstr("altered"), HasSubstr("Altered")))) << output;
        }
      }
    }
  }
}

TEST_F(AlteredOutputs, keep_the_file_s_hash_with_the_edits_beside_it) {
  const std::string line =
      "bench @scene.ply --frames 1 --warmup 0 --cull quadbox --backend cpu --out-dir @";
  ASSERT_EQ(run(line + "whole").exit_code, kExitOk);
  ASSERT_EQ(run(line + "rest --skip-huge --replicate 2x1").exit_code, kExitOk);
  const auto scene_of = [&](const char* name) {
    return nlohmann::json::parse(test::content_of(folder_ / name / "bench.json"))["scenes"][0];
  };
  const auto whole = scene_of("whole"), rest = scene_of("rest");
  EXPECT_FALSE(whole.contains("altered"));
  EXPECT_EQ(rest["hash"], whole["hash"]);
  EXPECT_EQ(rest["gaussians"], 598);
  EXPECT_EQ(rest["altered"]["edits"]["kept"], 299);
  EXPECT_EQ(rest["altered"]["edits"]["of"], 300);
  EXPECT_EQ(rest["altered"]["copies"], (nlohmann::json{2, 1}));
}

TEST_F(AlteredOutputs, of_different_alterations_are_not_merged) {
  const std::string line = "bench @scene.ply --frames 1 --warmup 0 --cull quadbox --backend cpu ";
  ASSERT_EQ(run(line + "--shard 1/2 --out-dir @a").exit_code, kExitOk);
  ASSERT_EQ(run(line + "--shard 2/2 --out-dir @b --splat-scale 0.5").exit_code, kExitOk);
  const ProgramRun merged = run("merge @a @b --out-dir @c");
  EXPECT_NE(merged.exit_code, kExitOk);
  EXPECT_THAT(merged.err, HasSubstr("splat scale 0.5"));
}

TEST_F(AlteredOutputs, of_an_edited_zoom_are_replayed_with_the_same_edits_only) {
  const std::string few = " --frames 1 --warmup 0 --backend cpu";
  ASSERT_EQ(run("zoom @scene.ply --steps 2 --skip-huge --splat-scale 0.5 --style ellipsoids "
                "--out-dir @zoom" +
                few)
                .exit_code,
            kExitOk);
  EXPECT_EQ(run("zoom --replay @zoom --skip-huge").exit_code, kExitOk);
  const ProgramRun whole = run("zoom --replay @zoom");
  EXPECT_EQ(whole.exit_code, kExitUsage);
  EXPECT_THAT(whole.err, HasSubstr("its scene was edited"));
}

}  // namespace
}  // namespace qs
