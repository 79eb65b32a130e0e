// SPDX-License-Identifier: MIT
// Comparison sheets, reports, and the lines that drawings are made of.
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/inspect/comparison_sheet.h"
#include "app/picture/canvas.h"
#include "app/picture/stroke.h"
#include "app/report/html_page.h"
#include "app/report/study_page.h"
#include "app/report/study_plots.h"
#include "app/run_program.h"
#include "io/image_file.h"
#include "support/scenes.h"
#include "support/shared.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::HasSubstr;

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

const std::string kPlush = test::source_path("assets/plush.ply").string();

TEST(Stroke, covers_as_much_as_its_length_and_width) {
  Image image(60, 40, 3);
  const glm::vec2 points[] = {{10.3f, 20.7f}, {50.3f, 20.7f}};
  stroke(image, points, false, {glm::vec3(1), 4});
  float sum = 0;
  for (std::size_t i = 0; i < image.values.size(); i += 3) sum += image.values[i];
  EXPECT_NEAR(sum, 40 * 4 + 3.14f * 4, 3);  // two half discs at the ends
}

TEST(Stroke, is_blended_once_where_it_crosses_itself) {
  Image image(40, 40, 3);
  const glm::vec2 points[] = {{5, 5}, {35, 35}, {35, 5}, {5, 35}};
  stroke(image, points, false, {glm::vec3(1), 5, 0.5f});
  for (const float value : image.values) EXPECT_LE(value, 0.5f);
  EXPECT_FLOAT_EQ(image.at(20, 20, 0), 0.5f);
}

TEST(Stroke, dashes_leave_gaps_of_their_own_length) {
  Image image(100, 10, 3);
  const glm::vec2 points[] = {{0, 5}, {100, 5}};
  stroke(image, points, false, {glm::vec3(1), 2, 1, 10});
  EXPECT_GT(image.at(5, 5, 0), 0.9f);
  EXPECT_EQ(image.at(15, 5, 0), 0);
  EXPECT_GT(image.at(25, 5, 0), 0.9f);
}

TEST(Stroke, polygons_have_their_area_and_everything_is_clipped) {
  Image image(50, 50, 3);
  const glm::vec2 triangle[] = {{10, 10}, {40, 10}, {10, 40}};
  fill_polygon(image, triangle, glm::vec3(1), 1);
  float sum = 0;
  for (std::size_t i = 0; i < image.values.size(); i += 3) sum += image.values[i];
  EXPECT_NEAR(sum, 450, 2);
  const glm::vec2 outside[] = {{-500, -500}, {900, -20}, {700, 900}};
  fill_polygon(image, outside, glm::vec3(0.5f), 1);
  stroke(image, outside, true, {glm::vec3(1), 3});
  EXPECT_FLOAT_EQ(image.at(49, 25, 1), 0.5f);
}

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

TEST(Comparison, differences_are_amplified_and_end_at_white) {
  Image truth(4, 1, 3), other = truth;
  other.at(1, 0, 0) = 2.0f / 255;
  other.at(2, 0, 0) = 1;
  const Image difference = amplified_difference(other, truth, {1, 0, 4, 1}, 16);
  EXPECT_FLOAT_EQ(difference.at(0, 0, 0), 32.0f / 255);
  EXPECT_FLOAT_EQ(difference.at(1, 0, 0), 1);
  EXPECT_EQ(difference.at(2, 0, 0), 0);
}

TEST(CompareCommand, writes_a_sheet_and_a_table) {
  const test::ProgramRun run =
      test::run_quadsplat({"compare", kPlush, "--size", "320x240", "--cull", "dualbox,quadbox",
                           "--output", (TemporaryFolder().path() / "gone.png").string()});
  EXPECT_EQ(run.exit_code, 2) << "a folder that does not exist";
  const TemporaryFolder folder;
  const test::ProgramRun good =
      test::run_quadsplat({"compare", kPlush, "--size", "320x240", "--cull", "dualbox,quadbox",
                           "--crop", "auto", "--output", (folder / "sheet.png").string()});
  ASSERT_EQ(good.exit_code, 0) << good.err;
  EXPECT_THAT(good.out, HasSubstr("against reference"));
  EXPECT_THAT(good.out, HasSubstr("first pixel"));  // of dualbox
  const Image sheet = read_image(folder / "sheet.png");
  EXPECT_GT(sheet.width, 1000);
}

TEST(CompareCommand, says_what_is_wrong_with_a_crop) {
  for (const char* crop : {"1,2,3", "1,2,0,5", "300,200,40,50", "x"}) {
    const test::ProgramRun run = test::run_quadsplat(
        {"compare", kPlush, "--size", "320x240", "--cull", "quadbox", "--crop", crop});
    EXPECT_EQ(run.exit_code, 1) << crop;
    EXPECT_THAT(run.err, HasSubstr("--crop")) << crop;
  }
}

TEST(InspectCommand, its_counts_are_those_of_render_s_statistics) {
  const TemporaryFolder folder;
  const std::string picture = (folder / "why.png").string();
  const test::ProgramRun run =
      test::run_quadsplat({"inspect", kPlush, "--camera-index", "0", "--size", "640x480", "--pixel",
                           "320,240", "--json", "--picture", picture});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["pixel"], nlohmann::json({320, 240}));
  EXPECT_GT(json["contributions"].size(), 0u);
  EXPECT_EQ(read_image(picture).width, 1800);
  const test::ProgramRun text = test::run_quadsplat(
      {"inspect", kPlush, "--size", "640x480", "--gaussian", json["picked"]["gaussian"].dump()});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("quadbox walks"));
}

TEST(InspectCommand, says_what_is_wrong) {
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

TEST(RenderCommand, draws_the_maps_of_what_is_wasted_and_what_is_lost) {
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

TEST(Html, shows_text_as_it_is_and_holds_its_pictures) {
  EXPECT_EQ(html_escaped("a < b & \"c\""), "a &lt; b &amp; &quot;c&quot;");
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  HtmlPage page("<title>");
  page.table({{"a", "b"}, {"1", "2"}});
  page.picture(Image(4, 4, 3), "four by four");
  EXPECT_THAT(page.text(), HasSubstr("<th>a</th>"));
  EXPECT_THAT(page.text(), HasSubstr("data:image/png;base64,iVBORw0KGgo"));
  EXPECT_THAT(page.text(), HasSubstr("&lt;title&gt;"));
}

TEST(Study, bins_hold_every_visible_gaussian_and_all_of_its_pairs) {
  const auto renderer = make_renderer(Backend::cpu, {.threads = 2});
  renderer->upload(test::random_cloud(2000, 0, 41), {});
  const Camera views[] = {test::front_camera(160, 120), test::front_camera(90, 70)};
  ThreadPool pool(2);
  const SceneStudy study = study_scene(*renderer, views, {}, pool, {});
  EXPECT_EQ(study.views, 2u);
  const auto& modes = study.modes[1];
  for (const BinnedPairs& binned : study.binned) {
    EXPECT_EQ(std::accumulate(binned.gaussians.begin(), binned.gaussians.end(), std::uint64_t{0}),
              study.visible);
    EXPECT_EQ(std::accumulate(binned.pairs[0].begin(), binned.pairs[0].end(), std::uint64_t{0}),
              modes[0].pairs);
  }
  for (const auto& size : study.modes) {
    for (const ModeStudy& mode : size) {
      EXPECT_EQ(mode.uses.pairs(), mode.pairs);
      EXPECT_EQ(std::accumulate(mode.loads.begin(), mode.loads.end(), std::uint64_t{0}),
                mode.pairs);
    }
  }
  EXPECT_EQ(study.telling.saved, study.telling.pairs[1] - study.telling.pairs[4]);
}

TEST(Study, a_value_falls_into_the_bin_between_its_edges) {
  for (const Quantity& quantity : quantities()) {
    EXPECT_EQ(bin_of(quantity, -1), 0u);
    EXPECT_EQ(bin_of(quantity, 1e12), kBins - 1);
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      EXPECT_EQ(bin_of(quantity, quantity.edges[bin]), bin) << quantity.name;
      EXPECT_FALSE(bin_label(quantity, bin).empty());
    }
  }
}

TEST(ReportCommand, writes_one_page_that_needs_nothing_else) {
  const TemporaryFolder folder;
  const std::filesystem::path page = folder / "plush.html";
  const test::ProgramRun run = test::run_quadsplat(
      {"report", kPlush, "--size", "320x240", "--views", "2", "--output", page.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string html = text_of(page);
  for (const char* words : {"Pairs that nobody needed", "Which Gaussians bring the savings",
                            "How evenly the tiles are loaded", "Other tile sizes", "hidden"})
    EXPECT_THAT(html, HasSubstr(words));
  EXPECT_EQ(html.find("http"), std::string::npos) << "nothing is fetched";
  EXPECT_EQ(html.find("src=\"/"), std::string::npos);
  EXPECT_EQ(test::run_quadsplat({"report", kPlush}).exit_code, 1);
}

}  // namespace
}  // namespace qs
