// SPDX-License-Identifier: MIT
//
// The values that every curve of a plot takes from its data block, compared with the rows from
// which they come.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/report/bench_report.h"
#include "app/report/study_page.h"
#include "app/report/train_page.h"
#include "app/report/zoom_bundle.h"
#include "support/random_reports.h"

namespace qs {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Words of a gnuplot line; quoted words without their quotes.
std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream in(line);
  for (char c; in >> std::ws && in.get(c);) {
    std::string word;
    if (c == '"') {
      while (in.get(c) && c != '"') word += c;
    } else {
      in.unget();
      in >> word;
    }
    words.push_back(word);
  }
  return words;
}

/// One element of a plot command, with the values that it draws.
struct Curve {
  std::string text, title, color;
  std::vector<std::string> labels;           ///< per row: of xtic(COLUMN); may be empty
  std::vector<std::vector<double>> columns;  ///< per column of `using`: its values, row by row
};

/// A plot's commands as gnuplot reads them: every curve with its columns resolved.
struct Script {
  std::string settings;
  std::vector<std::string> histograms;  ///< titles of newhistogram, in order
  std::vector<Curve> curves;
  std::vector<std::size_t> first_curve;  ///< per histogram

  explicit Script(const Plot& plot) {
    std::istringstream in(plot.commands);
    std::string command;
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with("$") && line.ends_with(" << END")) {
        auto& rows = blocks_[line.substr(0, line.find(' '))];
        while (std::getline(in, line) && line != "END") rows.push_back(words_of(line));
      } else if (line.starts_with("plot ") || !command.empty()) {
        command += line + " ";
      } else {
        settings += line + "\n";
      }
    }
    command.erase(0, 5);
    for (std::size_t at; (at = command.find(", \\")) != std::string::npos;) {
      add(command.substr(0, at));
      command.erase(0, at + 3);
    }
    add(command);
  }

  const Curve& titled(const std::string& title) const {
    const auto found = std::find_if(curves.begin(), curves.end(),
                                    [&](const Curve& curve) { return curve.title == title; });
    if (found == curves.end()) throw std::runtime_error("no curve " + title);
    return *found;
  }

 private:
  void add(const std::string& text) {
    const std::vector<std::string> words = words_of(text);
    if (words[0] == "newhistogram") {
      histograms.push_back(words[1]);
      first_curve.push_back(curves.size());
      return;
    }
    Curve& curve = curves.emplace_back();
    curve.text = text;
    for (std::size_t i = 1; i < words.size(); ++i) {
      if (words[i] == "title") curve.title = words[i + 1];
      if (words[i] == "rgb") curve.color = words[i + 1];
      if (words[i] == "using") resolve(blocks_.at(words[0]), words[i + 1], curve);
    }
  }

  static void resolve(const std::vector<std::vector<std::string>>& rows, const std::string& using_,
                      Curve& curve) {
    std::istringstream in(using_);
    for (std::string part; std::getline(in, part, ':');) {
      const bool is_label = part.starts_with("xtic(");
      const auto column = static_cast<std::size_t>(std::stoi(is_label ? part.substr(5) : part)) - 1;
      if (!is_label) curve.columns.emplace_back();
      for (const auto& row : rows) {
        if (is_label) curve.labels.push_back(row.at(column));
        if (!is_label) curve.columns.back().push_back(std::stod(row.at(column)));
      }
    }
  }

  std::map<std::string, std::vector<std::vector<std::string>>> blocks_;
};

const Plot& named(const std::vector<Plot>& plots, const std::string& name) {
  const auto found =
      std::find_if(plots.begin(), plots.end(), [&](const Plot& plot) { return plot.name == name; });
  if (found == plots.end()) throw std::runtime_error("no plot " + name);
  return *found;
}

constexpr const char* kScenes[] = {"first", "second"};
constexpr const char* kModes[] = {"quadbox", "3dgs", "exact"};

BenchReport two_scenes() {
  BenchReport report;
  report.environment = {{"cpu", "some CPU"}};
  for (const char* scene : kScenes) {
    for (std::uint64_t view = 0; view < 3; ++view) {
      for (const char* mode : kModes) {
        report.rows.push_back(test::random_row(scene, mode, view));
        report.rows.back().gaussians = scene == kScenes[0] ? 1'000'000 : 4'000'000;
      }
    }
  }
  return report;
}

double mean_over_views(const std::vector<BenchRow>& rows, const std::string& scene,
                       const std::string& mode, double BenchRow::*member) {
  double sum = 0;
  int count = 0;
  for (const BenchRow& row : rows) {
    if (row.scene != scene || row.mode != mode) continue;
    sum += row.*member;
    ++count;
  }
  return sum / count;
}

double mean_pairs(const std::vector<BenchRow>& rows, const std::string& scene,
                  const std::string& mode) {
  std::vector<BenchRow> copies = rows;
  for (BenchRow& row : copies) row.frame_ms = static_cast<double>(row.pairs);
  return mean_over_views(copies, scene, mode, &BenchRow::frame_ms);
}

TEST(BenchPlots, bars_of_frames_per_second_come_from_the_median_and_whiskers_from_rounds) {
  const BenchReport report = two_scenes();
  const Script script(named(bench_plots(report, false), "fps"));
  EXPECT_THAT(script.settings, HasSubstr("set ylabel \"frames per second\""));
  ASSERT_EQ(script.curves.size(), std::size(kModes));
  for (const char* mode : kModes) {
    const Curve& curve = script.titled(mode);
    ASSERT_EQ(curve.columns.size(), 3u);
    for (std::size_t s = 0; s < 2; ++s) {
      EXPECT_EQ(curve.labels[s], kScenes[s]);
      std::vector<BenchRow> rows = report.rows;
      for (BenchRow& row : rows) {
        std::sort(row.round_ms.begin(), row.round_ms.end());
        row.ms_p05 = row.round_ms.front();
        row.ms_p95 = row.round_ms.back();
      }
      const auto mean = [&](double BenchRow::*member) {
        return mean_over_views(rows, kScenes[s], mode, member);
      };
      EXPECT_NEAR(curve.columns[0][s], 1000 / mean(&BenchRow::ms_median), 1e-9);
      EXPECT_NEAR(curve.columns[1][s], 1000 / mean(&BenchRow::ms_p95), 1e-9);
      EXPECT_NEAR(curve.columns[2][s], 1000 / mean(&BenchRow::ms_p05), 1e-9);
    }
  }
}

TEST(BenchPlots, whiskers_do_not_show_how_different_cameras_are_and_need_two_rounds) {
  BenchReport report = two_scenes();
  for (BenchRow& row : report.rows) {
    row.ms_median = 1.0 + 10.0 * static_cast<double>(row.view);
    row.round_ms = {row.ms_median, row.ms_median};
  }
  const Script steady(named(bench_plots(report, false), "fps"));
  for (const Curve& curve : steady.curves) {
    EXPECT_NEAR(curve.columns.at(1)[0], curve.columns[0][0], 1e-9);
    EXPECT_NEAR(curve.columns.at(2)[0], curve.columns[0][0], 1e-9);
  }
  report.rows[0].round_ms.resize(1);
  const Plot single = named(bench_plots(report, false), "fps");
  EXPECT_THAT(single.title, HasSubstr("one round"));
  EXPECT_THAT(single.commands, testing::Not(HasSubstr("errorbars")));
  for (const Curve& curve : Script(single).curves) EXPECT_EQ(curve.columns.size(), 1u);
}

TEST(BenchPlots, stages_are_stacked_in_their_order_for_every_mode_and_scene) {
  constexpr double BenchRow::*kStageMembers[] = {&BenchRow::preprocess_ms, &BenchRow::bin_ms,
                                                 &BenchRow::sort_ms, &BenchRow::blend_ms};
  const BenchReport report = two_scenes();
  const Script script(named(bench_plots(report, false), "stages"));
  EXPECT_THAT(script.histograms, testing::ElementsAre("first", "second"));
  EXPECT_THAT(script.first_curve, testing::ElementsAre(0u, 4u));
  ASSERT_EQ(script.curves.size(), 8u);
  for (std::size_t s = 0; s < 2; ++s) {
    std::set<std::string> colors;
    for (std::size_t stage = 0; stage < 4; ++stage) {
      const Curve& curve = script.curves[4 * s + stage];
      EXPECT_EQ(curve.title, s == 0 ? kStageNames[stage] : "");
      EXPECT_EQ(curve.color, script.curves[stage].color) << "a stage has one colour";
      colors.insert(curve.color);
      for (std::size_t m = 0; m < std::size(kModes); ++m) {
        if (stage == 0) {
          EXPECT_EQ(curve.labels[m], kModes[m]);
        }
        EXPECT_NEAR(curve.columns.at(0)[m],
                    mean_over_views(report.rows, kScenes[s], kModes[m], kStageMembers[stage]),
                    1e-9);
      }
    }
    EXPECT_EQ(colors.size(), 4u);
  }
}

TEST(BenchPlots, pairs_and_scaling_come_from_their_columns) {
  const BenchReport report = two_scenes();
  const std::vector<Plot> plots = bench_plots(report, true);
  const Script pairs(named(plots, "pairs")), scaling(named(plots, "scaling"));
  EXPECT_THAT(pairs.settings, HasSubstr("pairs (millions)"));
  EXPECT_THAT(scaling.settings, HasSubstr("set xlabel \"Gaussians (millions)\""));
  EXPECT_THAT(scaling.settings, HasSubstr("set ylabel \"time per frame (ms)\""));
  for (const char* mode : kModes) {
    const Curve &bars = pairs.titled(mode), &curve = scaling.titled(mode);
    EXPECT_EQ(bars.color, curve.color) << "a mode has one colour";
    ASSERT_EQ(bars.columns.size(), 1u);
    ASSERT_EQ(curve.columns.size(), 2u);
    for (std::size_t s = 0; s < 2; ++s) {
      EXPECT_EQ(bars.labels[s], kScenes[s]);
      EXPECT_NEAR(bars.columns[0][s], mean_pairs(report.rows, kScenes[s], mode) / 1e6, 1e-9);
      EXPECT_NEAR(curve.columns[0][s], s == 0 ? 1 : 4, 1e-9);
      EXPECT_NEAR(curve.columns[1][s],
                  mean_over_views(report.rows, kScenes[s], mode, &BenchRow::ms_median), 1e-9);
    }
  }
  EXPECT_EQ(bench_plots(report, false).size(), 3u) << "scaling is drawn on request";
}

ZoomBundle zoom_of_five_steps() {
  ZoomBundle bundle;
  bundle.environment = {{"cpu", "some CPU"}};
  bundle.steps = 5;
  bundle.closest = 0.0625;
  for (const char* mode : kModes) bundle.modes.push_back(find_culler(mode));
  for (std::uint64_t step = 0; step < 5; ++step) {
    for (const char* mode : kModes) {
      bundle.rows.push_back(test::random_row("scene", mode, step));
      BenchRow& row = bundle.rows.back();
      row.frames = kFewestBarFrames;
      row.ms_spread = 0.0625 * row.ms_median;
      row.drift = 0;
    }
  }
  return bundle;
}

/// The first column of a zoom's curves is the zoom, then come `members` of the mode's rows.
void expect_values(const Curve& curve, const ZoomBundle& bundle, std::size_t mode,
                   const std::vector<std::function<double(const BenchRow&)>>& members) {
  ASSERT_EQ(curve.columns.size(), 1 + members.size());
  for (std::size_t step = 0; step < 5; ++step) {
    EXPECT_NEAR(curve.columns[0].at(step), std::exp2(step), 1e-9) << curve.text;
    const BenchRow& row = bundle.rows[step * bundle.modes.size() + mode];
    for (std::size_t i = 0; i < members.size(); ++i)
      EXPECT_NEAR(curve.columns[1 + i].at(step), members[i](row), 1e-9) << curve.text;
  }
}

TEST(ZoomPlots, curves_and_bars_come_from_their_columns) {
  using Members = std::vector<std::function<double(const BenchRow&)>>;
  const ZoomBundle bundle = zoom_of_five_steps();
  struct Case {
    const char *name, *label;
    Members line, bar;
  };
  const Case cases[] = {
      {"zoom_fps",
       "frames per second",
       {[](const BenchRow& r) { return r.fps_median; }},
       {[](const BenchRow& r) { return r.fps_median; },
        [](const BenchRow& r) { return 1000 / (r.ms_median * 1.0625); },
        [](const BenchRow& r) { return 1000 / (r.ms_median * 0.9375); },
        [](const BenchRow& r) { return r.fps_median; }}},
      {"zoom_ms",
       "time per frame (ms)",
       {[](const BenchRow& r) { return r.ms_median; }},
       {[](const BenchRow& r) { return r.ms_median; },
        [](const BenchRow& r) { return r.ms_median * 0.9375; },
        [](const BenchRow& r) { return r.ms_median * 1.0625; },
        [](const BenchRow& r) { return r.ms_median; }}},
      {"zoom_pairs",
       "pairs (millions)",
       {[](const BenchRow& r) { return static_cast<double>(r.pairs) / 1e6; }},
       {}},
  };
  const std::vector<Plot> plots = zoom_plots(bundle);
  ASSERT_EQ(plots.size(), std::size(cases));
  for (const Case& expected : cases) {
    const Script script(named(plots, expected.name));
    EXPECT_THAT(script.settings, HasSubstr(std::string("set ylabel \"") + expected.label + "\""));
    ASSERT_EQ(script.curves.size(), (expected.bar.empty() ? 1 : 2) * std::size(kModes));
    for (std::size_t m = 0; m < std::size(kModes); ++m) {
      const Curve& line = script.titled(kModes[m]);
      expect_values(line, bundle, m, expected.line);
      if (expected.bar.empty()) continue;
      Curve bar = script.curves[m];
      EXPECT_THAT(bar.text, HasSubstr("financebars")) << "bars are drawn below all curves";
      EXPECT_EQ(bar.color, line.color);
      // Side by side, 0.6 % of the four octaves apart.
      for (std::size_t step = 0; step < 5; ++step) {
        const double aside = std::log2(bar.columns[0][step]) - static_cast<double>(step);
        EXPECT_NEAR(aside, 0.024 * (static_cast<double>(m) - 1), 1e-4);
      }
      bar.columns[0] = line.columns[0];
      expect_values(bar, bundle, m, expected.bar);
    }
  }
}

TEST(ZoomPlots, a_bar_needs_five_frames_at_every_point_and_is_not_claimed_without_them) {
  ZoomBundle bundle = zoom_of_five_steps();
  EXPECT_THAT(named(zoom_plots(bundle), "zoom_fps").title, HasSubstr("bars: the middle half"));
  EXPECT_THAT(named(zoom_plots(bundle), "zoom_fps").caption, HasSubstr("; medians of 5 frames"));
  const Plot pairs = named(zoom_plots(bundle), "zoom_pairs");
  EXPECT_THAT(pairs.title, Not(HasSubstr("bars")));
  EXPECT_THAT(pairs.caption, Not(HasSubstr("medians"))) << "counts have no noise";
  const auto expect_no_bars = [&](const char* note) {
    for (const char* name : {"zoom_fps", "zoom_ms"}) {
      const Plot plot = named(zoom_plots(bundle), name);
      EXPECT_THAT(plot.title, Not(HasSubstr("bars"))) << note;
      EXPECT_THAT(plot.commands, Not(HasSubstr("financebars"))) << note;
      EXPECT_THAT(plot.caption, HasSubstr(note));
    }
  };
  bundle.rows[7].frames = kFewestBarFrames - 1;
  expect_no_bars("; medians of 4 frames");
  bundle.rows[7].frames = 1;
  expect_no_bars("; single frames");
  bundle.rows[7].frames.reset();  // a file of an earlier version
  expect_no_bars("some CPU");
}

TEST(ZoomPlots, noisy_steps_are_told_below_the_axis_and_have_rings) {
  ZoomBundle bundle = zoom_of_five_steps();
  EXPECT_THAT(named(zoom_plots(bundle), "zoom_ms").commands, Not(HasSubstr("noisy")));
  bundle.rows[3].ms_spread = bundle.rows[3].ms_median;
  EXPECT_THAT(named(zoom_plots(bundle), "zoom_ms").commands,
              HasSubstr(R"x(distance)" . "\n" . "noisy steps: quadbox 1 of 5")x"));
  for (const auto& [name, median] :
       {std::pair("zoom_fps", &BenchRow::fps_median), std::pair("zoom_ms", &BenchRow::ms_median)}) {
    const Script script(named(zoom_plots(bundle), name));
    ASSERT_EQ(script.curves.size(), 3 * std::size(kModes) + 1);
    EXPECT_EQ(script.curves.back().title, "noisy step");
    const Curve& ring = script.curves[2 * std::size(kModes)];
    EXPECT_EQ(ring.color, script.titled("quadbox").color);
    for (std::size_t step = 0; step < 5; ++step) {
      const double value = ring.columns[1][step];
      EXPECT_EQ(std::isnan(value), step != 1) << name;
      EXPECT_TRUE(step != 1 || std::abs(value - bundle.rows[3].*median) < 1e-9) << name;
    }
  }
  EXPECT_THAT(named(zoom_plots(bundle), "zoom_pairs").commands, Not(HasSubstr("noisy")));
}

TEST(ZoomPlots, say_how_the_scene_was_altered) {
  ZoomBundle bundle = zoom_of_five_steps();
  EXPECT_EQ(named(zoom_plots(bundle), "zoom_fps").altered, "");
  for (BenchRow& row : bundle.rows) row.altered = "splat scale 0.5";
  for (const Plot& plot : zoom_plots(bundle)) EXPECT_EQ(plot.altered, "splat scale 0.5");
}

TEST(ZoomPlots, a_processor_has_its_threads) {
  EXPECT_EQ(measured_on({{"cpu", "some CPU"}, {"threads", 2}}), "some CPU, 2 threads");
  EXPECT_EQ(measured_on({{"cpu", "some CPU"}, {"threads", 1}}), "some CPU, 1 thread");
  EXPECT_EQ(measured_on({{"cpu", "some CPU"}, {"threads", 2}, {"gpu", "some GPU"}}), "some GPU");
}

std::vector<std::string> texts_of(const std::vector<AxisTick>& ticks) {
  std::vector<std::string> texts;
  for (const AxisTick& tick : ticks) texts.push_back(tick.text);
  return texts;
}

TEST(ZoomPlots, the_zoom_s_axis_has_round_ticks) {
  using testing::ElementsAre;
  EXPECT_THAT(texts_of(zoom_ticks(20)), ElementsAre("1x", "2x", "5x", "10x", "20x"));
  EXPECT_THAT(texts_of(zoom_ticks(1 / 0.05)), ElementsAre("1x", "2x", "5x", "10x", "20x"));
  EXPECT_THAT(texts_of(zoom_ticks(2)), ElementsAre("1x", "2x"));
  EXPECT_THAT(texts_of(zoom_ticks(150)),
              ElementsAre("1x", "2x", "5x", "10x", "20x", "50x", "100x"));
  EXPECT_THAT(texts_of(zoom_ticks(1.1)), ElementsAre("1.00x", "1.05x", "1.10x"));
  EXPECT_THAT(texts_of(zoom_ticks(1.9)), ElementsAre("1.0x", "1.5x"));
  EXPECT_GE(zoom_ticks(1.001).size(), 2u);
}

TEST(ZoomPlots, an_axis_from_zero_has_round_ticks_up_to_the_first_above_all_values) {
  using testing::ElementsAre;
  EXPECT_THAT(texts_of(round_ticks(52.283)), ElementsAre("0", "20", "40", "60"));
  EXPECT_THAT(texts_of(round_ticks(100)), ElementsAre("0", "20", "40", "60", "80", "100"));
  EXPECT_THAT(texts_of(round_ticks(0.3)), ElementsAre("0.0", "0.1", "0.2", "0.3"));
  EXPECT_THAT(texts_of(round_ticks(1e-3)).back(), "0.0010");
  for (const double most : {0.017, 1.0, 3.3, 999.0, 1001.0, 4.9e6}) {
    const std::vector<AxisTick> ticks = round_ticks(most);
    EXPECT_LE(ticks.size(), 6u) << most;
    EXPECT_GE(ticks.size(), 3u) << most;
    EXPECT_EQ(ticks.front().value, 0);
    EXPECT_GE(ticks.back().value, most * (1 - 1e-9));
    EXPECT_LT(ticks[ticks.size() - 2].value, most);
  }
}

TEST(StudyPlots, uses_sizes_and_loads_come_from_the_study) {
  const SceneStudy study = test::random_study();
  const std::vector<Plot> plots = study_plots(study, "caption");
  const Script uses(named(plots, "uses")), sizes(named(plots, "sizes")),
      loads(named(plots, "loads"));
  ASSERT_EQ(uses.curves.size(), 3u);
  ASSERT_EQ(sizes.curves.size(), static_cast<std::size_t>(culler_count()));
  ASSERT_EQ(loads.curves.size(), static_cast<std::size_t>(culler_count()));
  for (std::size_t mode = 0; mode < static_cast<std::size_t>(culler_count()); ++mode) {
    const std::string name = mode_name(static_cast<CullMode>(mode) + 1);
    const ModeStudy& usual = study.modes[1][mode];  // tiles of 16 pixels
    EXPECT_EQ(uses.curves[0].labels[mode], name);
    EXPECT_NEAR(uses.titled("used by a pixel").columns[0][mode],
                static_cast<double>(usual.uses.used) / 1e6, 1e-9);
    EXPECT_NEAR(uses.titled("hidden").columns[0][mode],
                static_cast<double>(usual.uses.hidden) / 1e6, 1e-9);
    EXPECT_NEAR(uses.titled("empty").columns[0][mode], static_cast<double>(usual.uses.empty) / 1e6,
                1e-9);
    for (std::size_t size = 0; size < 3; ++size) {
      const auto& modes = study.modes[size];
      EXPECT_NEAR(sizes.titled(name).columns[0][size],
                  static_cast<double>(modes[mode].pairs) / static_cast<double>(modes[0].pairs),
                  1e-9);
    }
    const Curve& curve = loads.titled(name);
    for (const std::size_t percent : {0u, 1u, 50u, 99u, 100u}) {
      const auto at = static_cast<std::size_t>(
          std::find(curve.columns[0].begin(), curve.columns[0].end(), percent) -
          curve.columns[0].begin());
      EXPECT_EQ(curve.columns[1].at(at), usual.loads[10 * percent]) << percent;
    }
  }
  EXPECT_THAT(sizes.curves[0].labels, testing::ElementsAre("8 x 8", "16 x 16", "32 x 32"));
}

TEST(StudyPlots, bins_come_from_the_study) {
  const SceneStudy study = test::random_study();
  const std::vector<Plot> plots = study_plots(study, "caption");
  for (std::size_t q = 0; q < quantities().size(); ++q) {
    const std::string key = quantities()[q].key;
    const Script count(named(plots, "count_" + key)), saved(named(plots, "saved_" + key));
    ASSERT_EQ(count.curves.size(), 1u);
    ASSERT_EQ(saved.curves.size(), static_cast<std::size_t>(culler_count() - 2))
        << "all but 3dgs and quadbox-naive";
    const BinnedPairs& binned = study.binned[q];
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      EXPECT_EQ(count.curves[0].labels[bin], bin_label(quantities()[q], bin));
      EXPECT_NEAR(count.curves[0].columns[0][bin], static_cast<double>(binned.gaussians[bin]) / 1e3,
                  1e-9);
      for (const char* mode : {"adr", "dualbox", "quadbox", "exact"}) {
        const auto& pairs = binned.pairs[static_cast<std::size_t>(find_culler(mode)) - 1];
        const double expected =
            (static_cast<double>(binned.pairs[0][bin]) - static_cast<double>(pairs[bin])) / 1e6;
        EXPECT_NEAR(saved.titled(mode).columns[0][bin], expected, 1e-9) << mode;
        EXPECT_EQ(saved.titled(mode).labels[bin], bin_label(quantities()[q], bin));
      }
    }
  }
}

TEST(StudyPlots, labels_of_neighbouring_bins_share_their_edge) {
  for (const GaussianQuantity& quantity : quantities()) {
    const auto high_of = [&](std::size_t bin) {
      const std::string label = bin_label(quantity, bin);
      return label.substr(label.find_first_of("<-") + 1);
    };
    for (std::size_t bin = 1; bin < kBins; ++bin)
      EXPECT_TRUE(bin_label(quantity, bin).starts_with(high_of(bin - 1))) << quantity.name;
  }
}

TEST(TrainPlots, curves_come_from_the_log_and_only_finite_evaluations_have_a_psnr) {
  train::TrainLog log;
  log.rows = {{100, 1, 0.25, 2000, {}},
              {200, 2, 0.125, 3500, train::Quality{20, 0.5}},
              {300, 3, 0.0625, 3600, train::Quality{INFINITY, 1}},
              {400, 4, 0.05, 3700, train::Quality{24.5, 0.75}}};
  const std::vector<Plot> plots = train::train_plots(log, "caption");
  ASSERT_EQ(plots.size(), 3u);
  using testing::ElementsAre;
  EXPECT_THAT(Script(named(plots, "loss")).curves[0].columns,
              ElementsAre(ElementsAre(100, 200, 300, 400), ElementsAre(0.25, 0.125, 0.0625, 0.05)));
  EXPECT_THAT(Script(named(plots, "psnr")).curves[0].columns,
              ElementsAre(ElementsAre(200, 400), ElementsAre(20, 24.5)));
  EXPECT_THAT(Script(named(plots, "gaussians")).curves[0].columns,
              ElementsAre(ElementsAre(100, 200, 300, 400), ElementsAre(2, 3.5, 3.6, 3.7)));
  log.guard = {{150, 21.5, 30}, {250, 22, 31}};
  EXPECT_THAT(Script(named(train::train_plots(log, "caption"), "reserved")).curves[0].columns,
              ElementsAre(ElementsAre(150, 250), ElementsAre(21.5, 22)));
  log.guard.clear();
  log.rows.resize(1);
  EXPECT_EQ(train::train_plots(log, "").size(), 2u) << "nothing was evaluated";
  log.rows.clear();
  EXPECT_TRUE(train::train_plots(log, "").empty());
}

TEST(Plots, a_mode_has_a_colour_and_a_marker_of_its_own) {
  std::set<std::string> colors;
  std::set<int> markers;
  for (CullMode mode = 1; mode <= mode_count(); ++mode) {
    colors.insert(mode_color_option(mode_name(mode)));
    markers.insert(mode_marker(mode_name(mode)));
  }
  EXPECT_EQ(colors.size(), static_cast<std::size_t>(mode_count()));
  EXPECT_EQ(markers.size(), static_cast<std::size_t>(mode_count()));
  EXPECT_EQ(mode_color_option("quadbox"), "linecolor rgb \"#0072B2\"");
  EXPECT_EQ(mode_color_option("unknown"), "linecolor rgb \"#808080\"");
}

}  // namespace
}  // namespace qs
