// SPDX-License-Identifier: MIT
//
// The numbers in printed tables, compared with the measurements from which they come.
#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/inspect/comparison_sheet.h"
#include "app/measure/statistics.h"
#include "app/report/markdown.h"
#include "app/report/study_page.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "support/random_reports.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::ElementsAre;
using Table = std::vector<std::vector<std::string>>;

/// The tables of a Markdown text by the heading above them, without head and ruler.
std::map<std::string, Table> markdown_tables(const std::string& text) {
  std::map<std::string, Table> tables;
  std::istringstream in(text);
  std::string heading;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("## ")) heading = line.substr(3);
    if (!line.starts_with("| `")) continue;
    auto& row = tables[heading].emplace_back();
    std::istringstream cells(line.substr(2));
    for (std::string cell; std::getline(cells, cell, '|');) {
      std::erase(cell, '`');
      row.push_back(cell.substr(0, cell.find_last_not_of(' ') + 1));
      row.back().erase(0, row.back().find_first_not_of(' '));
    }
  }
  return tables;
}

/// "1,234.5x" -> 1234.5
double number(std::string text) {
  std::erase(text, ',');
  return std::stod(text);
}

// Tables have the digits that the spread of the frames leaves: the unit of the number behind the
// plus-minus sign, or about a tenth of the value where a cell does not show its spread.
void expect_about(const std::string& cell, double value) {
  const std::size_t sign = cell.find("\u00b1");
  double tolerance = 0.12 * value + 0.000501;
  if (sign != cell.npos)
    tolerance = 0.51 * std::pow(10.0, std::floor(std::log10(number(cell.substr(sign + 2)))));
  EXPECT_NEAR(number(cell), value, tolerance) << cell;
}

BenchReport report_of(std::vector<BenchRow> rows) {
  return {{{"cpu", "some CPU"}, {"backend", "cpu"}, {"commit", "abc"}},
          nlohmann::ordered_json::array(),
          rows.size(),
          std::move(rows)};
}

TEST(BenchTable, has_the_means_over_the_cameras_of_a_scene) {
  std::vector<BenchRow> rows;
  for (const char* scene : {"first", "second"}) {
    for (std::uint64_t view = 0; view < 3; ++view) {
      for (const char* mode : {"3dgs", "quadbox"}) {
        rows.push_back(test::random_row(scene, mode, view));
        rows.back().gaussians = rows.size() < 7 ? 1234567 : 7654321;
        rows.back().psnr_vs_reference = 40 + rows.back().ms_p05;
      }
    }
  }
  rows.back().psnr_vs_reference.reset();  // second, quadbox
  const auto tables = markdown_tables(format_markdown(report_of(rows)));
  double log_ratio = 0, mean_ms = 0;
  for (const std::string scene : {"first", "second"}) {
    std::map<std::string, BenchRow> sums;  // per mode; psnr in frame_ms, pairs in bin_ms
    for (const BenchRow& row : rows) {
      if (row.scene != scene) continue;
      BenchRow& sum = sums[row.mode];
      sum.ms_median += row.ms_median / 3;
      sum.bin_ms += static_cast<double>(row.pairs) / 3;
      sum.frame_ms += row.psnr_vs_reference.value_or(NAN) / 3;
      sum.sort_ms += static_cast<double>(*row.sort_bytes) / 3;
    }
    double product = 1;  // of the ratios of 3 cameras in 3 rounds
    for (const BenchRow& row : rows) {
      if (row.scene != scene) continue;
      for (const double ms : row.round_ms) product *= row.mode == "3dgs" ? ms : 1 / ms;
    }
    const Table& table = tables.at(scene);
    ASSERT_EQ(table.size(), 2u);
    for (const auto& cells : table) {
      const BenchRow& sum = sums.at(cells[0]);
      const double ratio = cells[0] == "3dgs" ? 1 : std::pow(product, 1.0 / 9);
      ASSERT_EQ(cells.size(), 8u);
      EXPECT_EQ(cells[1], scene == "first" ? "1,234,567" : "7,654,321");
      if (std::isnan(sum.frame_ms)) {
        EXPECT_EQ(cells[2], "-") << "one camera has no PSNR";
      } else {
        EXPECT_NEAR(number(cells[2]), sum.frame_ms, 0.00501);
      }
      expect_about(cells[3], sum.ms_median);
      expect_about(cells[4], 1000 / sum.ms_median);
      expect_about(cells[5], ratio);
      EXPECT_NEAR(number(cells[6]), sum.bin_ms, 0.51);
      EXPECT_EQ(cells[7], bytes_text(static_cast<std::uint64_t>(sum.sort_ms)));
      if (cells[0] != "quadbox") continue;
      log_ratio += std::log(ratio) / 2;
      mean_ms += sum.ms_median / 2;
    }
  }
  const auto& mean = tables.at("Mean of 2 scenes").at(1);
  EXPECT_EQ(mean[0], "quadbox");
  EXPECT_EQ(mean[1], "4,444,444");
  EXPECT_EQ(mean[2], "-");
  expect_about(mean[3], mean_ms);
  expect_about(mean[4], 1000 / mean_ms);
  EXPECT_NEAR(number(mean[5]), std::exp(log_ratio), 0.00501);
}

TEST(BenchTable, the_paper_s_fps_is_that_of_the_mean_time_and_its_mean_that_of_the_scenes) {
  std::vector<BenchRow> rows;
  for (const char* scene : {"first", "second"}) {
    for (std::uint64_t view = 0; view < 2; ++view)
      rows.push_back(test::random_row(scene, "adr", view));
  }
  BenchReport report = report_of(rows);
  EXPECT_FALSE(parse_own_json(format_bench_json(report)).contains("fps_paper"));
  EXPECT_EQ(format_markdown(report).find("FPS (paper)"), std::string::npos);
  const double times[] = {2, 8, 1, 3};
  for (std::size_t i = 0; i < 4; ++i) report.rows[i].ms_paper = times[i];
  const auto tables = markdown_tables(format_markdown(report));
  EXPECT_EQ(tables.at("first")[0][5], "200.0");
  EXPECT_EQ(tables.at("second")[0][5], "500.0");
  EXPECT_EQ(tables.at("Mean of 2 scenes")[0][5], "350.0");
  const auto json = parse_own_json(format_bench_json(report));
  const auto& list = json.at("fps_paper");
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[0]["scene"], "first");
  EXPECT_EQ(list[0]["mode"], "adr");
  EXPECT_EQ(list[0]["fps"], 200);
  EXPECT_TRUE(list[2]["scene"].is_null());
  EXPECT_EQ(list[2]["mode"], "adr");
  EXPECT_EQ(list[2]["fps"], 350);
  EXPECT_EQ(format_csv(parse_bench_report(json).rows), format_csv(report.rows));
  report.rows[1].ms_paper.reset();
  EXPECT_EQ(markdown_tables(format_markdown(report)).at("first")[0][5], "-");
}

// CUDA classic sorts pairs by (tile, depth); CUDA fast sorts pairs by tile and Gaussians by depth;
// the CPU sorts Gaussians by depth. Values have 4 bytes.
TEST(BenchTable, names_with_bars_stay_in_their_cells) {
  BenchRow row;
  row.scene = "a|scene";
  row.camera = "left|right";
  row.mode = "quadbox";
  row.ms_median = 1;
  row.drift = 0.5;  // noisy
  BenchReport report;
  report.environment = nlohmann::ordered_json::object();
  report.rows = {row};
  const auto bars = [](const std::string& line) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < line.size(); ++i)
      count += line[i] == '|' && (i == 0 || line[i - 1] != '\\') ? 1 : 0;
    return count;
  };
  std::istringstream lines(format_markdown(report) + noise_markdown(report.rows));
  std::size_t columns = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("|")) columns = 0;
    if (!line.starts_with("|")) continue;
    if (columns == 0) columns = bars(line);
    EXPECT_EQ(bars(line), columns) << line;
  }
}

TEST(BenchTable, sort_bytes_are_those_of_the_rows_if_all_have_them) {
  const auto sort_bytes = [](std::optional<std::uint64_t> first,
                             std::optional<std::uint64_t> second) {
    std::vector<BenchRow> rows = {test::random_row("scene", "quadbox", 0),
                                  test::random_row("scene", "quadbox", 1)};
    rows[0].sort_bytes = first;
    rows[1].sort_bytes = second;
    return markdown_tables(format_markdown(report_of(rows))).at("scene").at(0).back();
  };
  EXPECT_EQ(sort_bytes(2'000'000, 4'000'000), bytes_text(3'000'000));
  EXPECT_EQ(sort_bytes(0, 0), bytes_text(0));
  EXPECT_EQ(sort_bytes(2'000'000, std::nullopt), "-");
}

/// The tables of an HTML page, with their heads.
std::vector<Table> html_tables(const std::string& html) {
  std::vector<Table> tables;
  for (std::size_t at = html.find('<'); at != html.npos; at = html.find('<', at + 1)) {
    const std::string tag = html.substr(at, html.find('>', at) + 1 - at);
    if (tag == "<table>") tables.emplace_back();
    if (tag == "<tr>") tables.back().emplace_back();
    if (tag.starts_with("<td") || tag.starts_with("<th")) {
      const std::size_t text = at + tag.size();
      tables.back().back().push_back(html.substr(text, html.find('<', text) - text));
    }
  }
  return tables;
}

std::string two_digits(double value) { return fmt::format("{:.2f}", value); }
std::string percent(double share) { return fmt::format("{:.1f} %", 100 * share); }

/// The page of a study without gnuplot: with all tables.
std::string page_without_plots(const SceneStudy& study) {
  const TemporaryFolder folder;
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);
  std::string problem;
  const std::string html =
      format_study_page({study, "scene", "view", "caption", {}, {}, "made here"}, problem);
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(problem, "gnuplot is not installed");
  return html;
}

TEST(StudyPage, tables_have_the_numbers_of_the_study) {
  const SceneStudy study = test::random_study();
  const std::vector<Table> tables = html_tables(page_without_plots(study));
  ASSERT_EQ(tables.size(), 4 + quantities().size());
  const Table &costs = tables[0], &uses = tables[1], &loads = tables[tables.size() - 2],
              &sizes = tables.back();
  EXPECT_THAT(uses[0], ElementsAre("mode", "pairs", "used", "hidden", "empty", "false positives"));
  EXPECT_THAT(loads[0], ElementsAre("mode", "mean", "median", "99 % of tiles", "longest",
                                    "longest over mean"));
  for (std::size_t i = 0; i < static_cast<std::size_t>(culler_count()); ++i) {
    const auto& [pairs, use, load] = study.modes[1][i];  // tiles of 16 pixels
    const auto count = static_cast<double>(pairs);
    const auto wasted = static_cast<double>(use.hidden + use.empty);
    const char* name = mode_name(static_cast<CullMode>(i) + 1);
    EXPECT_THAT(costs[i + 1],
                ElementsAre(name, row_of(static_cast<CullMode>(i + 1)).summary, grouped(pairs),
                            two_digits(count / static_cast<double>(study.modes[1][0].pairs)),
                            two_digits(count / static_cast<double>(study.visible)),
                            percent(wasted / count), two_digits(study.frame_ms[i]),
                            two_digits(study.frame_ms[i] / study.frame_ms[0])));
    const std::uint64_t all = use.used + use.hidden + use.empty;
    EXPECT_THAT(uses[i + 1],
                ElementsAre(name, grouped(all), grouped(use.used), grouped(use.hidden),
                            grouped(use.empty), percent(wasted / static_cast<double>(all))));
    EXPECT_THAT(loads[i + 1],
                ElementsAre(name, fmt::format("{:.1f}", count / 1001), grouped(load[500]),
                            grouped(load[990]), grouped(load[1000]),
                            fmt::format("{:.1f}", load[1000] / (count / 1001))));
    for (std::size_t size = 0; size < 3; ++size) {
      const auto& [size_pairs, size_use, unused] = study.modes[size][i];
      const auto size_count = static_cast<double>(size_pairs);
      EXPECT_EQ(sizes[i + 1][1 + 3 * size], grouped(size_pairs));
      EXPECT_EQ(sizes[i + 1][2 + 3 * size],
                two_digits(size_count / static_cast<double>(study.modes[size][0].pairs)));
      EXPECT_EQ(sizes[i + 1][3 + 3 * size],
                percent(static_cast<double>(size_use.hidden + size_use.empty) / size_count));
    }
  }
  EXPECT_EQ(sizes[0][1], "8 x 8: pairs");
  EXPECT_EQ(sizes[0][7], "32 x 32: pairs");
}

TEST(StudyPage, bins_have_the_numbers_of_the_study_and_the_largest_saving_is_named) {
  SceneStudy study = test::random_study();
  study.binned[2].pairs[0].fill(1000);  // 3dgs
  study.binned[2].pairs[4].fill(900);   // quadbox
  study.binned[2].pairs[4][7] = 300;
  const std::string html = page_without_plots(study);
  const std::vector<Table> tables = html_tables(html);
  for (std::size_t q = 0; q < quantities().size(); ++q) {
    const Table& table = tables[2 + q];
    EXPECT_THAT(table[0], ElementsAre(quantities()[q].name, "Gaussians", "3dgs", "adr", "dualbox",
                                      "quadbox-naive", "quadbox", "exact"));
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      EXPECT_EQ(table[bin + 1][1], grouped(study.binned[q].gaussians[bin]));
      for (std::size_t mode = 0; mode < static_cast<std::size_t>(culler_count()); ++mode)
        EXPECT_EQ(table[bin + 1][2 + mode], grouped(study.binned[q].pairs[mode][bin]));
    }
  }
  EXPECT_THAT(html, testing::HasSubstr("Quadbox saves most in the range 24-32: " +
                                       percent(700.0 / (700 + 11 * 100)) + " of all pairs"));
}

TEST(StudyPage, the_example_has_the_pairs_of_the_modes_that_it_names) {
  SceneStudy study = test::random_study();
  study.example = {0, 4321, {60, 50, 30, 41, 40, 20}, 10};
  std::string problem;
  const std::string html = format_study_page(
      {study, "scene", "view", "caption", {}, {{Image(4, 4, 3), "it"}}, ""}, problem);
  EXPECT_THAT(html, testing::HasSubstr("Gaussian 4,321 has 60 pairs in mode 3dgs, 50 in adr, 40 in "
                                       "quadbox and 20 in exact."));
}

TEST(ComparisonTable, has_the_numbers_of_every_variant) {
  ViewComparison comparison;
  comparison.truth_name = "reference";
  for (const std::uint64_t scale : {1u, 3u}) {
    ViewVariant& variant = comparison.variants.emplace_back();
    variant.name = scale == 1 ? "quadbox" : "exact";
    variant.psnr = 40.25 * static_cast<double>(scale);
    variant.largest = static_cast<int>(17 * scale);
    variant.stats.tile_pairs = 12345 * scale;
    variant.stats.used_pairs = 12345;
  }
  const std::string table = format_comparison(comparison);
  std::istringstream in(table.substr(table.find("quadbox")));
  std::vector<std::string> words((std::istream_iterator<std::string>(in)), {});
  EXPECT_THAT(words, ElementsAre("quadbox", "40.25", "17/255", "12,345", "0", "0.0", "%", "exact",
                                 "120.75", "51/255", "37,035", "24,690", "66.7", "%"));
}

}  // namespace
}  // namespace qs
