// SPDX-License-Identifier: MIT
//
// --edits: the same picture by every way, and edits of another scene.
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/cli/command.h"
#include "app/support/program_in_folder.h"
#include "io/bytes/file_hash.h"
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "support/pool.h"

namespace qs {
namespace {

using test::ProgramRun;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kRemovals = R"({"step":"select","tool":"opacity","high":0.4},
  {"step":"remove"},
  {"step":"select","tool":"rectangle","camera":CAMERA,"pixels":[[4,4],[20,20]]},
  {"step":"hide"},
  {"step":"select","tool":"brush","how":"add","kind":"through","radius":6,"camera":CAMERA,"pixels":[[22,12],[28,20]]})";

class EditedOutputs : public test::ProgramInFolder {
 protected:
  void write_edits(std::string steps, const std::string& scene = "{}") const {
    const std::string camera = format_camera(test::front_camera(32, 24));
    for (std::size_t at; (at = steps.find("CAMERA")) != steps.npos;) steps.replace(at, 6, camera);
    std::ofstream(folder_ / "a.edits.json")
        << fmt::format(R"({{"version": 1, "scene": {}, "steps": [{}]}})", scene, steps);
  }
  ProgramRun done(const std::string& line) const {
    const ProgramRun result = run(line);
    EXPECT_EQ(result.exit_code, kExitOk) << result.err;
    return result;
  }
  std::size_t gaussians(const std::string& file) const {
    return read_scene(folder_ / file, test::pool()).cloud.size();
  }
};

TEST_F(EditedOutputs, are_the_picture_of_the_rest_as_a_file) {
  write_edits(kRemovals);
  const ProgramRun edited = done("render @scene.ply --edits @a.edits.json --output @a.pfm");
  EXPECT_THAT(edited.err,
              AllOf(HasSubstr("edits: 5 steps, "), HasSubstr(" of 300 Gaussians are left, "),
                    HasSubstr("edited: 2 steps, ")));
  done("convert @scene.ply @rest.ply --edits @a.edits.json");
  done("render @rest.ply --output @b.pfm");
  done("render @scene.ply --output @c.pfm");
  EXPECT_EQ(test::content_of(folder_ / "a.pfm"), test::content_of(folder_ / "b.pfm"));
  EXPECT_NE(test::content_of(folder_ / "a.pfm"), test::content_of(folder_ / "c.pfm"));
  // The two parts of the rest.
  done("convert @scene.ply @selected.ply --edits @a.edits.json --edits-part selected");
  done("convert @scene.ply @others.ply --edits @a.edits.json --edits-part rest");
  EXPECT_GT(gaussians("selected.ply"), 0u);
  EXPECT_EQ(gaussians("selected.ply") + gaussians("others.ply"), gaussians("rest.ply"));
}

TEST_F(EditedOutputs, are_refused_for_another_scene_unless_that_is_wished) {
  const std::string hash = file_hash(folder_ / "scene.ply");
  const std::string line = "convert @scene.ply @out.ply --overwrite --edits @a.edits.json";
  write_edits(kRemovals, fmt::format(R"({{"hash": "{}", "gaussians": 300, "axes": "RDF"}})", hash));
  done(line);
  const std::pair<const char*, const char*> others[] = {
      {R"({"hash": "crc32:00000000", "name": "a.ply"})",
       "it is of a file with hash crc32:00000000, and scene.ply has "},
      {R"({"gaussians": 301})", "it is of a scene of 301 Gaussians, and scene.ply has 300"},
      {R"({"axes": "RUB"})", "its places are in axes RUB, and the scene was read with RDF"}};
  for (const auto& [scene, problem] : others) {
    write_edits(kRemovals, scene);
    const ProgramRun refused = run(line);
    EXPECT_EQ(refused.exit_code, static_cast<int>(ErrorKind::input));
    EXPECT_THAT(refused.err, HasSubstr(problem));
    EXPECT_THAT(done(line + " --edits-anyway").err,
                HasSubstr("1 selection of visible or touching Gaussians left out"));
  }
}

TEST_F(EditedOutputs, name_differences_if_selections_are_computed_again) {
  write_edits(R"({"step":"select","tool":"rectangle","camera":CAMERA,"pixels":[[4,4],[20,20]],
                 "count": 2, "members": [7, 2]})");
  const std::string line = "convert @scene.ply @out.ply --overwrite --edits @a.edits.json";
  EXPECT_THAT(done(line + " --edits-part selected").err,
              AllOf(HasSubstr("2 selected"), Not(HasSubstr("in place of"))));
  EXPECT_EQ(gaussians("out.ply"), 2u);
  EXPECT_THAT(done(line + " --recompute").err, HasSubstr("step 1: it selects "));
}

TEST_F(EditedOutputs, of_convert_are_scaled_and_level_and_other_commands_say_that_they_are_not) {
  write_edits(R"({"step":"scale","factor":2}, {"step":"level","rotation":[0,0,0.6,0.8]})");
  done("convert @scene.ply @out.ply --edits @a.edits.json");
  const Scene before = read_scene(folder_ / "scene.ply", test::pool());
  const Scene after = read_scene(folder_ / "out.ply", test::pool());
  ASSERT_EQ(after.cloud.size(), 300u);
  const glm::vec3 p = before.cloud.positions[5], q = after.cloud.positions[5];
  const float c = 0.28f, s = 0.96f;  // of twice the angle with cosine 0.8
  EXPECT_NEAR(q.x, 2 * (c * p.x - s * p.y), 1e-4);
  EXPECT_NEAR(q.y, 2 * (s * p.x + c * p.y), 1e-4);
  EXPECT_NEAR(q.z, 2 * p.z, 1e-4);
  EXPECT_NEAR(after.cloud.log_scales[5].x, before.cloud.log_scales[5].x + std::log(2.0f), 1e-5);
  EXPECT_THAT(done("render @scene.ply --edits @a.edits.json --output @a.png").err,
              HasSubstr("its scale and level are for convert"));
}

TEST_F(EditedOutputs, of_edits_that_leave_nothing_are_refused) {
  write_edits(R"({"step":"select","tool":"all"}, {"step":"remove"})");
  for (const char* line : {"convert @scene.ply @out.ply --edits @a.edits.json",
                           "render @scene.ply --output @a.png --edits @a.edits.json"}) {
    const ProgramRun refused = run(line);
    EXPECT_EQ(refused.exit_code, kExitUsage);
    EXPECT_THAT(refused.err, HasSubstr("no Gaussian "));
  }
}

}  // namespace
}  // namespace qs
