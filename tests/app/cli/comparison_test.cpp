// SPDX-License-Identifier: MIT
// One view drawn in several ways, and the commands that explain views.
#include <filesystem>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/inspect/comparison_sheet.h"
#include "app/support/run_program.h"
#include "io/bytes/json_text.h"
#include "io/picture/image_file.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/shared.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::HasSubstr;

const std::string kPlush = test::source_path("assets/plush.ply").string();

TEST(Comparison, the_automatic_crop_holds_the_largest_difference) {
  const Image truth(200, 150, 3);
  ViewVariant same{"same", truth, {}, 0, 0, {}}, other = same;
  for (int y = 90; y < 100; ++y) {
    for (int x = 130; x < 140; ++x) other.color.at(x, y, 1) = 0.5f;
  }
  const PixelBox box = most_different_crop(truth, {same, other}, {40, 30});
  EXPECT_LE(box.x0, 130);
  EXPECT_GE(box.x1, 140);
  EXPECT_LE(box.y0, 90);
  EXPECT_GE(box.y1, 100);
  EXPECT_EQ(box.x1 - box.x0, 40);
  EXPECT_EQ(box.y1 - box.y0, 30);
  const PixelBox middle = most_different_crop(truth, {same}, {40, 30});
  EXPECT_EQ(middle.x0, 80);
  EXPECT_EQ(middle.y0, 60);
  const PixelBox whole = most_different_crop(truth, {other}, {4000, 3000});
  EXPECT_EQ(whole.x1 - whole.x0, 200);
}

TEST(Variant, is_named_by_the_parts_that_differ) {
  const CullMode exact = find_culler("exact"), adr = find_culler("adr");
  const Variant cpu{exact, Pipeline::fast, Backend::cpu};
  const Variant gpu{adr, Pipeline::fast, Backend::cuda};
  const Variant classic{adr, Pipeline::classic, Backend::cuda};
  const Variant reference{kReferenceMode, Pipeline::fast, Backend::cpu};
  EXPECT_EQ(full_name(cpu), "exact, cpu");
  EXPECT_EQ(full_name(classic), "adr, cuda classic");
  EXPECT_EQ(full_name(reference), "reference");
  EXPECT_EQ(name_beside(cpu, {adr, Pipeline::classic, Backend::cpu}), "exact");
  EXPECT_EQ(name_beside(gpu, classic), "adr, cuda fast");
  EXPECT_EQ(name_beside(cpu, gpu), "exact, cpu");
  EXPECT_EQ(name_beside(gpu, reference), "adr");
  EXPECT_EQ(name_beside(reference, gpu), "reference");
  EXPECT_EQ(find_variant("exact, cpu", gpu), cpu);
  EXPECT_EQ(find_variant("reference", cpu), reference);
  EXPECT_EQ(find_variant("adr", {exact, Pipeline::classic, Backend::cuda}), classic);
  EXPECT_FALSE(find_variant("adr, somewhere", cpu));
}

TEST(CompareCommand, writes_a_sheet_and_a_table) {
  const TemporaryFolder folder;
  const test::ProgramRun good =
      test::run_quadsplat({"compare", kPlush, "--size", "320x240", "--cull", "dualbox,quadbox",
                           "--part", "auto", "--output", (folder / "sheet.png").string()});
  ASSERT_EQ(good.exit_code, 0) << good.err;
  EXPECT_THAT(good.out, HasSubstr("against reference"));
  EXPECT_THAT(good.out, HasSubstr("first pixel"));  // of dualbox
  const Image sheet = read_image(folder / "sheet.png");
  EXPECT_GT(sheet.width, 1000);
  const test::ProgramRun nowhere =
      test::run_quadsplat({"compare", kPlush, "--size", "64x48", "--cull", "quadbox", "--against",
                           "adr", "--output", (folder / "missing" / "sheet.png").string()});
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("missing"));
}

// Dimmer colours make the differences of dualbox smaller.
TEST(CompareCommand, names_a_pixel_if_a_difference_is_above_the_tolerance_and_not_at_it) {
  const TemporaryFolder folder;
  test::write_cameras({test::front_camera(60, 40)}, folder / "cameras.json");
  const GaussianCloud bright = test::random_cloud(400, 0, 5);
  constexpr float kBase = 0.28209479f;  // of the colour's constant part
  bool at_tolerance = false, above = false;
  for (float factor = 0.01f; factor < 1 && !(at_tolerance && above); factor *= 1.1f) {
    GaussianCloud cloud = bright;
    for (glm::vec3& sh : cloud.sh) sh = ((0.5f + kBase * sh) * factor - 0.5f) / kBase;
    test::write_scene(cloud, folder / "scene.ply");
    const test::ProgramRun run =
        test::run_quadsplat({"compare", (folder / "scene.ply").string(), "--cull", "dualbox"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const std::string rest = run.out.substr(run.out.find("\ndualbox"));
    std::istringstream row(rest);
    std::string name, psnr, largest;
    row >> name >> psnr >> largest;
    const int difference = std::stoi(largest);
    EXPECT_EQ(rest.find(" the reference ") != std::string::npos, difference > 2) << run.out;
    at_tolerance = at_tolerance || difference == 2;
    above = above || difference > 2;
  }
  EXPECT_TRUE(at_tolerance && above);
}

TEST(CompareCommand, explains_a_wrong_crop) {
  for (const char* crop : {"1,2,3", "1,2,0,5", "300,200,40,50", "x"}) {
    const test::ProgramRun run = test::run_quadsplat(
        {"compare", kPlush, "--size", "320x240", "--cull", "quadbox", "--part", crop});
    EXPECT_EQ(run.exit_code, 1) << crop;
    EXPECT_THAT(run.err, HasSubstr("--part")) << crop;
  }
}

TEST(InspectCommand, its_counts_are_those_of_render_s_statistics) {
  const TemporaryFolder folder;
  const std::string picture = (folder / "why.png").string();
  const test::ProgramRun run =
      test::run_quadsplat({"inspect", kPlush, "--camera-index", "0", "--size", "640x480", "--pixel",
                           "320,240", "--json", "-", "--output", picture});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto report = parse_json(run.out, "test");
  EXPECT_EQ(report["pixel"], nlohmann::json({320, 240}));
  EXPECT_GT(report["contributions"].size(), 0u);
  EXPECT_EQ(read_image(picture).width, 1800);
  const test::ProgramRun text = test::run_quadsplat(
      {"inspect", kPlush, "--size", "640x480", "--gaussian", report["picked"]["gaussian"].dump()});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("quadbox walks"));
}

TEST(InspectCommand, explains_wrong_options) {
  const auto error_of = [](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"inspect", kPlush, "--size", "64x48"};
    words.insert(words.end(), more.begin(), more.end());
    const test::ProgramRun run = test::run_quadsplat(words);
    EXPECT_EQ(run.exit_code, 1);
    return run.err;
  };
  EXPECT_THAT(error_of({"--pixel", "64,0"}), HasSubstr("there is no pixel 64,0"));
  EXPECT_THAT(error_of({"--pixel", "a,0"}), HasSubstr("--pixel"));
  EXPECT_THAT(error_of({"--gaussian", "1000000"}), HasSubstr("Gaussian 1000000 is not visible"));
  EXPECT_THAT(error_of({"--cull", "all"}), HasSubstr("choose one camera and one mode"));
  EXPECT_THAT(error_of({"--cull", "reference"}), HasSubstr("mode reference has no tiles"));
}

TEST(RenderCommand, draws_maps_of_false_positives_and_missed_contributions) {
  const TemporaryFolder folder;
  for (const char* map : {"false-positive", "missed"}) {
    const std::string path = (folder / (std::string(map) + ".png")).string();
    const test::ProgramRun run =
        test::run_quadsplat({"render", kPlush, "--size", "320x240", "--cull", "dualbox",
                             "--heatmap", map, "--output", path});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(read_image(path).width, 320);
    const bool missed = std::string(map) == "missed";
    EXPECT_EQ(run.err.find("contributions are missed") != std::string::npos, missed);
  }
  const test::ProgramRun lossless =
      test::run_quadsplat({"render", kPlush, "--size", "320x240", "--heatmap", "missed", "--output",
                           (folder / "none.png").string()});
  EXPECT_THAT(lossless.err, HasSubstr("no contribution is missed"));
}

}  // namespace
}  // namespace qs
