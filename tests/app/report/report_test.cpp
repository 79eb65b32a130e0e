// SPDX-License-Identifier: MIT
// The study of a scene, and its page.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/report/html_page.h"
#include "app/report/study_page.h"
#include "app/support/run_program.h"
#include "base/text.h"
#include "support/pool.h"
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

TEST(Html, shows_text_as_it_is_and_holds_its_pictures) {
  EXPECT_EQ(html_escaped("a < b & \"c\""), "a &lt; b &amp; &quot;c&quot;");
  HtmlPage page("<title>");
  page.table({{"a", "b"}, {"1", "2"}});
  page.table({{"a", "b"}, {"1", ""}});  // the decisive cell is empty
  page.picture(Image(4, 4, 3), "four by four");
  EXPECT_THAT(page.text(), HasSubstr("<th class=\"words\">a</th><th>b</th>"));
  EXPECT_THAT(page.text(), HasSubstr("data:image/png;base64,iVBORw0KGgo"));
  EXPECT_THAT(page.text(), HasSubstr("&lt;title&gt;"));
}

TEST(Study, bins_contain_every_visible_gaussian_and_all_of_its_pairs) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
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
  for (const double ms : study.frame_ms) EXPECT_GT(ms, 0);
  for (const auto& size : study.modes) {
    for (const ModeStudy& mode : size) {
      EXPECT_EQ(mode.uses.pairs(), mode.pairs);
      EXPECT_EQ(std::accumulate(mode.loads.begin(), mode.loads.end(), std::uint64_t{0}),
                mode.pairs);
    }
  }
  EXPECT_EQ(study.example.saved, study.example.pairs[1] - study.example.pairs[4]);
}

TEST(Study, uses_of_pairs_are_the_renderer_s_in_every_mode) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(test::random_cloud(2000, 0, 41), {});
  const Camera view = test::front_camera(160, 120);
  ThreadPool pool(2);
  const SceneStudy study = study_scene(*renderer, {&view, 1}, {}, pool, {});
  Outputs outputs;
  outputs.used = true;
  for (std::size_t size = 0; size < kTileSizes.size(); ++size) {
    for (CullMode mode = 1; mode <= culler_count(); ++mode) {
      RenderSettings settings;
      settings.mode = mode;
      settings.tile_px = kTileSizes[size];
      const RenderStats stats = renderer->render(view, settings, outputs).stats;
      const PairUses& uses = study.modes[size][static_cast<std::size_t>(mode - 1)].uses;
      EXPECT_EQ(uses.used, *stats.used_pairs) << mode_name(mode) << " " << settings.tile_px;
      EXPECT_EQ(uses.pairs(), stats.tile_pairs) << mode_name(mode) << " " << settings.tile_px;
    }
  }
}

TEST(Study, a_value_falls_into_the_bin_between_its_edges) {
  for (const GaussianQuantity& quantity : quantities()) {
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
  for (const char* words : {"Pairs that no pixel uses", "Which Gaussians the savings come from",
                            "How evenly the pairs are distributed", "Other tile sizes", "hidden"})
    EXPECT_THAT(html, HasSubstr(words));
  EXPECT_THAT(html, HasSubstr("data:image/svg+xml;base64,"));
  EXPECT_EQ(html.find("http"), std::string::npos) << "nothing is fetched";
  EXPECT_EQ(html.find("src=\"/"), std::string::npos);
  EXPECT_EQ(test::run_quadsplat({"report", kPlush}).exit_code, 1);
}

TEST(ReportCommand, has_tables_and_says_so_where_gnuplot_is_missing) {
  const TemporaryFolder folder;
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);
  const test::ProgramRun run =
      test::run_quadsplat({"report", kPlush, "--size", "160x120", "--camera-index", "0", "--output",
                           (folder / "out").string()});
  setenv("PATH", path.c_str(), 1);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("no plots: gnuplot is not installed"));
  const std::string html = text_of(folder / "out" / "report.html");
  EXPECT_THAT(html, HasSubstr("This page has tables only, no plots: gnuplot is not installed."));
  EXPECT_THAT(html, HasSubstr("<td>"));
}

TEST(ReportCommand, says_before_the_work_that_there_is_no_such_folder) {
  const TemporaryFolder folder;
  const test::ProgramRun run =
      test::run_quadsplat({"report", kPlush, "--output", (folder / "missing/page.html").string()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("does not exist"));
}

}  // namespace
}  // namespace qs
