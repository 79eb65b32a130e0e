// SPDX-License-Identifier: MIT
//
// The scripts of plots, the tables and pages of reports and the texts of the inspector, made of
// fixed numbers and compared with texts in tests/golden/reports. plots_test.cpp and tables_test.cpp
// compare the numbers with their rows.
#include <cstdlib>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "app/inspect/heatmap_frame.h"
#include "app/inspect/inspection.h"
#include "app/inspect/reference_check.h"
#include "app/report/bench_report.h"
#include "app/report/html_page.h"
#include "app/report/markdown.h"
#include "app/report/study_page.h"
#include "app/report/zoom_bundle.h"
#include "support/golden.h"
#include "support/random_reports.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

/// Pictures are left out, because the bytes of a PNG file depend on the library.
void expect_golden(const std::string& name, std::string text) {
  constexpr std::string_view kPicture = "png;base64,";
  for (std::size_t at = 0; (at = text.find(kPicture, at)) != text.npos;) {
    at += kPicture.size();
    text.erase(at, text.find('"', at) - at);
  }
  test::expect_golden_text("reports/" + name + ".txt", text);
}

std::string text_of(const std::vector<Plot>& plots) {
  std::string text;
  for (const Plot& plot : plots)
    text += plot.name + "\n" + plot.title + "\n" + plot.caption + "\n" + plot.commands + "\n\n";
  return text;
}

/// A row whose numbers follow from `seed`.
BenchRow bench_row(const std::string& scene, const std::string& mode, std::uint64_t view,
                   int seed) {
  BenchRow row;
  row.scene = scene;
  row.mode = mode;
  row.pipeline = "cpu";
  row.backend = "cpu";
  row.view = view;
  row.camera = std::to_string(view);
  row.width = 640;
  row.height = 360;
  row.gaussians = 500'000 * static_cast<std::uint32_t>(seed % 3 + 1);
  row.visible = 1000 * static_cast<std::uint32_t>(seed) + 17;
  row.pairs = 123'457u * static_cast<std::uint64_t>(seed);
  row.sort_bytes = 8 * row.pairs;
  double value = 0.5 + seed;
  for (double* member : {&row.ms_median, &row.ms_p05, &row.ms_p95, &row.fps_median, &row.frame_ms,
                         &row.preprocess_ms, &row.bin_ms, &row.sort_ms, &row.blend_ms})
    *member = value += 0.25;
  row.round_ms = {row.ms_median - 0.125, row.ms_median + 0.0625 * seed, row.ms_median};
  return row;
}

BenchReport bench_of(const std::vector<std::string>& scenes) {
  BenchReport report;
  report.environment = {
      {"cpu", "some CPU"}, {"backend", "cpu"}, {"commit", "abc"}, {"utc", "noon"}};
  int seed = 0;
  for (const std::string& scene : scenes) {
    for (std::uint64_t view = 0; view < 2; ++view) {
      for (const char* mode : {"3dgs", "quadbox-naive", "exact"})
        report.rows.push_back(bench_row(scene, mode, view, ++seed));
    }
  }
  return report;
}

TEST(ReportText, bench_of_one_scene) {
  BenchReport report = bench_of({"plush"});
  report.rows.resize(3);  // one camera
  for (BenchRow& row : report.rows) row.round_ms.resize(1);
  expect_golden("bench_one", format_markdown(report) + text_of(bench_plots(report, false)));
}

TEST(ReportText, bench_of_four_scenes_in_two_pipelines) {
  BenchReport report = bench_of({"a", "b \"quoted\"", "c", "d"});
  report.environment["gpu"] = "some GPU";
  report.environment["baseline"] = "exact";
  for (std::size_t i = 0; i < report.rows.size(); ++i) {
    report.rows[i].backend = "cuda";
    report.rows[i].pipeline = i % 2 == 0 ? "fast" : "classic";
    if (i > 12) report.rows[i].height = 480;
  }
  expect_golden("bench_four", format_markdown(report) + text_of(bench_plots(report, true)));
}

TEST(ReportText, zoom) {
  ZoomBundle bundle;
  bundle.environment = {{"cpu", "some CPU"}};
  bundle.steps = 24;
  bundle.closest = 0.125;
  int seed = 0;
  for (const char* mode : {"quadbox-naive", "exact"}) bundle.modes.push_back(find_culler(mode));
  for (std::uint64_t step = 0; step < 24; ++step) {
    for (const char* mode : {"quadbox-naive", "exact"}) {
      bundle.rows.push_back(bench_row("plush", mode, step, ++seed));
      bundle.rows.back().frames = 20;
    }
  }
  expect_golden("zoom", text_of(zoom_plots(bundle)));
  bundle.rows.clear();
  EXPECT_TRUE(zoom_plots(bundle).empty());
}

/// A study whose numbers follow from their position.
SceneStudy study() {
  SceneStudy study;
  study.views = 2;
  study.gaussians = 4321;
  study.visible = 2100;
  study.binned.resize(quantities().size());
  std::uint32_t next = 100;
  for (BinnedPairs& binned : study.binned) {
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      binned.gaussians[bin] = next += 7;
      for (auto& mode : binned.pairs) mode[bin] = 5000 - (next += 3) % 700;
    }
  }
  for (auto& size : study.modes) {
    for (ModeStudy& mode : size) {
      next += 111;
      mode.uses = {3 * next, next, 2 * next + 5};
      mode.pairs = 6 * next + 5;
      for (std::uint32_t i = 0; i < 301; ++i) mode.loads.push_back(i * i / 16 + next % 50);
    }
  }
  study.example = {1, 1234, {60, 50, 30, 41, 40, 20}, 10};
  return study;
}

std::string page(const SceneStudy& study, const std::vector<CaptionedImage>& example) {
  const TemporaryFolder folder;
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);
  std::string problem;
  const std::string html = format_study_page({study,
                                              "plush",
                                              "camera 1",
                                              "caption",
                                              {{Image(2, 1, 3), "half a <picture>"}},
                                              example,
                                              "made"},
                                             problem);
  setenv("PATH", path.c_str(), 1);
  return html;
}

TEST(ReportText, study) {
  expect_golden("study", text_of(study_plots(study(), "plush, 2 views")) +
                             page(study(), {{Image(1, 2, 3), "an example"}}));
}

TEST(ReportText, study_of_an_empty_view) {
  SceneStudy empty;
  empty.binned.resize(quantities().size());
  expect_golden("study_empty", text_of(study_plots(empty, "nothing")) + page(empty, {}));
}

TEST(ReportText, scripts_are_complete) {
  const TemporaryFolder folder;
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);
  const Plot plots[] = {{"one", "a \"title\"", "a caption", "plot $x using 1"},
                        {"two", "b", "c", "plot $y using 1"}};
  const std::string sentence = draw_plots(folder.path(), plots);
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(sentence, "gnuplot is not installed; draw the plots with 'cd " +
                          folder.path().string() + " && gnuplot *.gp'");
  std::string text;
  for (const char* name : {"one.gp", "two.gp"}) {
    std::ifstream file(folder / name);
    text += std::string(std::istreambuf_iterator<char>(file), {}) + "\n";
  }
  expect_golden("scripts", text);
}

TEST(ReportText, html_pages) {
  HtmlPage html("a & b");
  html.heading("<1>");
  html.paragraph("\"quoted\"");
  html.table({{"head", "words", "numbers"}, {"row", "yes", "1"}, {"row", "2", "three"}});
  html.table({{"only", "a head"}});
  html.table({{"head", "numbers"}, {"1", "2"}});
  html.table({{"head", "words"}, {"1", "yes"}});
  html.picture(Image(1, 1, 3), "whole");
  html.picture(Image(1, 1, 3), "half", true);
  expect_golden("html", html.text());
}

Inspection inspection_of(std::size_t contributions, bool stopped) {
  Inspection inspection;
  PixelReport& pixel = inspection.pixel;
  pixel.pixel = {12, 34};
  pixel.tile = 56;
  pixel.listed = 7890;
  pixel.evaluated = 1234;
  pixel.transmittance = 0.0321f;
  pixel.color = {0.125f, 0.25f, 0.5f};
  for (std::size_t i = 0; i < contributions; ++i) {
    const auto x = static_cast<float>(i);
    pixel.contributions.push_back({static_cast<std::uint32_t>(100 + i),
                                   1.5f + x,
                                   0.5f / (1 + x),
                                   0.25f / (1 + x),
                                   0.125f / (1 + x),
                                   {0.1f, 0.2f, 0.3f}});
  }
  if (stopped) pixel.stopped_by = Contribution{999, 77, 0.75f, 0.0625f, 0, {0.4f, 0.5f, 0.6f}};
  return inspection;
}

void add_gaussian(Inspection& inspection, int lines, bool walks_rows) {
  GaussianReport& g = inspection.gaussian.emplace();
  g.gaussian = 101;
  g.depth = 2.5f;
  g.opacity = 0.625f;
  g.color = {0.7f, 0.8f, 0.9f};
  g.footprint = make_footprint({10.25f, 20.5f}, {40, 12, 25}, 3.5f);
  g.visible = walks_rows;
  g.f = 0.375f;
  g.half_axes = {30, 10};
  g.anisotropy = 3;
  g.tilt = 0.5f;
  g.square = {{1, 2}, {3, 4}};
  g.adr = {{5, 6}, {7, 8}};
  g.dual_boxes = {{{9, 10}, {11, 12}}};
  g.quad_boxes = {{{13, 14}, {15, 16}}, {{17, 18}, {19, 20}}};
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    ModeTiles& tiles = g.modes.emplace_back();
    tiles.mode = mode;
    tiles.walks_rows = walks_rows;
    for (int i = 0; i < lines; ++i) tiles.runs.push_back({i + 3, {2 * i, 3 * i + 1}});
    std::vector<PairUse>& uses = inspection.uses.emplace_back();
    for (int i = 0; i < 3 * mode; ++i) {
      tiles.tiles.push_back(10 * mode + i);
      uses.push_back(i < mode - 1 ? PairUse::used : i == mode ? PairUse::hidden : PairUse::empty);
    }
  }
}

TEST(ReportText, inspections) {
  std::string text;
  for (const std::size_t count : {0u, 2u, 40u, 41u})
    text += format_inspection(inspection_of(count, count == 2)) + "\n";
  for (const int lines : {0, 1, 40, 42}) {
    Inspection inspection = inspection_of(1, false);
    add_gaussian(inspection, lines, lines % 2 == 0);
    text += format_inspection(inspection) + "\n";
    if (lines < 2) text += inspection_json(inspection).dump(1) + "\n";
  }
  text += inspection_json(inspection_of(2, true)).dump(1) + "\n";
  expect_golden("inspections", text);
}

TEST(ReportText, sentences_about_differences) {
  MissedMap missed;
  std::string text = missed_sentence(missed) + "\n";
  missed.total = 12345;
  missed.pixels = 678;
  missed.largest_alpha = 0.4567f;
  missed.largest_error = 0.1234f;
  text += missed_sentence(missed) + "\n";
  ReferenceCheck check;
  text += check_sentence(check, 2) + "\n";
  check.difference = {41.236, 9, {3, 4}, 1234, glm::ivec2(5, 6)};
  check.tile = 7;
  text += check_sentence(check, 3) + "\n";
  for (int why = 0; why < 6; ++why) {
    check.gaussian = static_cast<std::uint32_t>(100 + why);
    check.why = static_cast<Disagreement>(why);
    text += check_sentence(check, 3) + "\n";
  }
  expect_golden("sentences", text);
}

}  // namespace
}  // namespace qs
