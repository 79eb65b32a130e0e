// SPDX-License-Identifier: MIT
//
// Ratios of benchmarks and their intervals, compared with tables of Student's t distribution, with
// its density, and with products and roots of the times.
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/measure/paired_ratios.h"
#include "app/measure/statistics.h"
#include "app/report/bench_report.h"
#include "app/report/markdown.h"

namespace qs {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(StudentT, has_the_values_of_printed_tables) {
  const std::pair<std::size_t, double> table[] = {
      {1, 12.706}, {2, 4.303},  {3, 3.182},  {4, 2.776},  {5, 2.571},  {6, 2.447},
      {7, 2.365},  {8, 2.306},  {9, 2.262},  {10, 2.228}, {15, 2.131}, {20, 2.086},
      {25, 2.060}, {30, 2.042}, {40, 2.021}, {60, 2.000}, {120, 1.980}};
  for (const auto& [degrees, factor] : table)
    EXPECT_NEAR(student_t95(degrees), factor, 0.00051) << degrees;
  EXPECT_NEAR(student_t95(100'000), 1.95999, 0.0001);
}

TEST(StudentT, holds_95_per_cent_of_the_density) {
  for (const std::size_t degrees : {1u, 2u, 3u, 4u, 7u, 12u, 63u}) {
    const auto n = static_cast<double>(degrees);
    const double scale =
        std::exp(std::lgamma((n + 1) / 2) - std::lgamma(n / 2)) / std::sqrt(n * std::numbers::pi);
    const double end = student_t95(degrees);
    constexpr int kSteps = 20'000;  // Simpson's rule from 0 to the end
    double sum = 0;
    for (int i = 0; i <= kSteps; ++i) {
      const double t = end * i / kSteps;
      const double weight = i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2;
      sum += weight * scale * std::pow(1 + t * t / n, -(n + 1) / 2);
    }
    EXPECT_NEAR(2 * sum * end / kSteps / 3, 0.95, 1e-7) << degrees;
  }
}

TEST(GeometricMean, of_two_ratios_has_the_interval_of_one_degree_of_freedom) {
  // The logarithms differ by log 4, so their mean has a standard error of log 2.
  const Ratio mean = geometric_mean(std::array{2.0, 8.0});
  EXPECT_NEAR(mean.value, 4, 1e-12);
  EXPECT_EQ(mean.samples, 2u);
  ASSERT_TRUE(mean.interval);
  EXPECT_NEAR(mean.interval->low, 4 / std::pow(2, 12.7062047), 1e-7);
  EXPECT_NEAR(mean.interval->high, 4 * std::pow(2, 12.7062047), 0.02);
}

TEST(GeometricMean, of_inverse_ratios_is_the_inverse) {
  const std::array ratios = {1.5, 1.25, 1.8, 1.4};
  std::array<double, 4> inverse{};
  for (std::size_t i = 0; i < ratios.size(); ++i) inverse[i] = 1 / ratios[i];
  const Ratio there = geometric_mean(ratios), back = geometric_mean(inverse);
  EXPECT_NEAR(there.value, std::pow(1.5 * 1.25 * 1.8 * 1.4, 0.25), 1e-12);
  EXPECT_NEAR(there.value * back.value, 1, 1e-12);
  EXPECT_NEAR(there.interval->low * back.interval->high, 1, 1e-12);
  EXPECT_NEAR(there.interval->high * back.interval->low, 1, 1e-12);
}

TEST(Ratio, is_undecided_as_long_as_its_interval_has_one) {
  const auto undecided = [](double low, double high) {
    return is_undecided({(low + high) / 2, Interval{low, high}, 5});
  };
  EXPECT_TRUE(undecided(0.9, 1.1));
  EXPECT_TRUE(undecided(1, 1.1));
  EXPECT_TRUE(undecided(0.9, 1));
  EXPECT_FALSE(undecided(1.01, 1.1));
  EXPECT_FALSE(undecided(0.9, 0.99));
  EXPECT_FALSE(is_undecided({1, std::nullopt, 1}));
}

TEST(GeometricMean, of_one_ratio_has_no_interval_and_of_equal_ratios_an_empty_one) {
  const Ratio one = geometric_mean(std::array{1.75});
  EXPECT_DOUBLE_EQ(one.value, 1.75);
  EXPECT_FALSE(one.interval);
  EXPECT_EQ(ratio_text(one), "1.75x");
  const Ratio equal = geometric_mean(std::array{1.75, 1.75, 1.75});
  EXPECT_NEAR(equal.interval->low, 1.75, 1e-12);
  EXPECT_NEAR(equal.interval->high, 1.75, 1e-12);
  EXPECT_EQ(ratio_text(equal).substr(0, 6), "1.750x");
}

TEST(GeometricMean, has_an_interval_that_holds_the_truth_in_95_of_100_experiments) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(std::log(1.3), 0.2);
  constexpr int kExperiments = 8000;
  int holds = 0;
  for (int i = 0; i < kExperiments; ++i) {
    std::array<double, 5> ratios{};
    for (double& ratio : ratios) ratio = std::exp(noise(random));
    const Ratio mean = geometric_mean(ratios);
    holds += mean.interval->low <= 1.3 && 1.3 <= mean.interval->high;
  }
  EXPECT_NEAR(static_cast<double>(holds) / kExperiments, 0.95, 0.008);  // over three deviations
}

BenchRow row_of_times(const std::string& mode, std::uint64_t view, std::vector<double> round_ms,
                      const std::string& scene = "scene", const std::string& pipeline = "fast") {
  BenchRow result;
  result.scene = scene;
  result.camera = "camera " + std::to_string(view);
  result.mode = mode;
  result.pipeline = pipeline;
  result.backend = "cpu";
  result.view = view;
  result.round_ms = std::move(round_ms);
  result.ms_median = result.round_ms.front();
  return result;
}

TEST(PairedRatios, compare_times_of_the_same_round_so_that_slow_rounds_cancel) {
  // The second round took twice as long in every mode; the medians of all rounds give the same
  // ratio.
  const std::optional<Ratio> ratio =
      paired_ratio(row_of_times("3dgs", 0, {3, 6, 3.3}), row_of_times("adr", 0, {2, 4, 2.2}));
  ASSERT_TRUE(ratio);
  EXPECT_NEAR(ratio->value, 1.5, 1e-12);
  EXPECT_NEAR(ratio->interval->low, 1.5, 1e-9);
  EXPECT_NEAR(ratio->interval->high, 1.5, 1e-9);
  EXPECT_EQ(ratio->samples, 3u);
  EXPECT_EQ(
      paired_ratio(row_of_times("3dgs", 0, {3, 6}), row_of_times("adr", 0, {2, 4, 2.2}))->samples,
      2u);
  EXPECT_FALSE(paired_ratio(row_of_times("3dgs", 0, {0}), row_of_times("adr", 0, {0})));
}

TEST(PairedRatios, are_those_of_every_camera_and_their_geometric_mean) {
  const std::vector<BenchRow> rows = {
      row_of_times("3dgs", 0, {4, 5}), row_of_times("adr", 0, {2, 2}),
      row_of_times("3dgs", 1, {9, 9}), row_of_times("adr", 1, {3, 6}),
      row_of_times("3dgs", 2, {7, 7}), row_of_times("adr", 2, {5, 4})};
  const std::vector<PairedRatio> ratios = paired_ratios(rows, "3dgs");
  ASSERT_EQ(ratios.size(), 4u);
  const double expected[] = {std::sqrt(4.0 / 2 * 5 / 2), std::sqrt(9.0 / 3 * 9 / 6),
                             std::sqrt(7.0 / 5 * 7 / 4)};
  double mean = 0, squares = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(ratios[i].camera, "camera " + std::to_string(i));
    EXPECT_EQ(ratios[i].mode, "adr");
    EXPECT_NEAR(ratios[i].ratio.value, expected[i], 1e-12);
    EXPECT_EQ(ratios[i].ratio.samples, 2u);
    mean += std::log(expected[i]) / 3;
  }
  for (const double each : expected) squares += std::pow(std::log(each) - mean, 2);
  const double half = 4.3026527 * std::sqrt(squares / 2 / 3);  // two degrees of freedom
  EXPECT_EQ(ratios[3].camera, "");
  EXPECT_EQ(ratios[3].ratio.samples, 3u);
  EXPECT_NEAR(ratios[3].ratio.value, std::cbrt(expected[0] * expected[1] * expected[2]), 1e-12);
  EXPECT_NEAR(ratios[3].ratio.interval->low, std::exp(mean - half), 1e-6);
  EXPECT_NEAR(ratios[3].ratio.interval->high, std::exp(mean + half), 1e-6);
}

TEST(PairedRatios, stay_within_scene_and_pipeline_and_need_the_baseline) {
  const std::vector<BenchRow> rows = {
      row_of_times("adr", 0, {2}, "a"),
      row_of_times("3dgs", 0, {4}, "a"),
      row_of_times("adr", 0, {2}, "a", "classic"),
      row_of_times("3dgs", 0, {6}, "a", "classic"),
      row_of_times("adr", 0, {5}, "b"),
      row_of_times("3dgs", 0, {5}, "b"),
      row_of_times("adr", 1, {1}, "b"),  // without a baseline
  };
  std::vector<std::string> text;
  for (const PairedRatio& each : paired_ratios(rows, "3dgs")) {
    text.push_back(each.scene + " " + each.pipeline + " " + each.camera + " " +
                   ratio_text(each.ratio));
  }
  EXPECT_THAT(text, testing::ElementsAre("a fast camera 0 2.00x", "a fast  2.00x",
                                         "a classic camera 0 3.00x", "a classic  3.00x",
                                         "b fast camera 0 1.00x", "b fast  1.00x"));
  EXPECT_TRUE(paired_ratios(rows, "exact").empty());
  EXPECT_EQ(paired_ratios(rows, "adr").front().mode, "3dgs");
  EXPECT_NEAR(paired_ratios(rows, "adr").front().ratio.value, 0.5, 1e-12);
}

TEST(PairedRatios, of_one_round_compare_its_frames_and_need_five) {
  BenchRow base = row_of_times("3dgs", 0, {4}), row = row_of_times("adr", 0, {2});
  base.turn_ms = {4, 8, 4, 4, 8};
  row.turn_ms = {2, 4, 2.5, 1.6, 4};
  base.frames = row.frames = 5;
  const std::vector<PairedRatio> ratios = paired_ratios({base, row}, "3dgs");
  ASSERT_EQ(ratios.size(), 2u);
  EXPECT_EQ(ratios[0].ratio.samples, 5u);
  EXPECT_NEAR(ratios[0].ratio.value, 2, 1e-12);
  ASSERT_TRUE(ratios[1].ratio.interval);
  EXPECT_EQ(ratio_text(ratios[1].ratio), "2.0x \u00b10.4");
  base.frames = row.frames = 4;
  EXPECT_TRUE(paired_ratios({base, row}, "3dgs").empty());
  BenchRow other_base = base, other = row;  // two cameras of four frames have a mean ratio
  other_base.camera = other.camera = "camera 1";
  other_base.view = other.view = 1;
  const auto mean = paired_ratios({base, row, other_base, other}, "3dgs");
  ASSERT_EQ(mean.size(), 1u);
  EXPECT_EQ(mean[0].camera, "");
  base.turn_ms->pop_back();  // frames of different rounds are not compared
  EXPECT_FALSE(paired_ratio(base, row)->interval);
}

TEST(PairedRatios, are_undecided_if_their_interval_contains_1) {
  Ratio ratio{1.021, Interval{0.97, 1.06}, 9};
  EXPECT_TRUE(is_undecided(ratio));
  EXPECT_EQ(ratio_text(ratio), "1.02x \u00b10.05 noisy");
  ratio.interval->low = 1.01;
  EXPECT_EQ(ratio_text(ratio), "1.02x \u00b10.04");
}

TEST(BenchTable, of_one_camera_has_the_digits_of_its_spread_and_says_noisy) {
  BenchReport noisy;
  noisy.environment = {{"cpu", "some CPU"}};
  for (const double scale : {2.0, 1.0}) {
    BenchRow& row = noisy.rows.emplace_back(row_of_times(scale == 2 ? "3dgs" : "adr", 0, {0}));
    row.turn_ms = {6.1234 * scale, 4.1 * scale, 5.1234 * scale, 6.2 * scale, 4.2 * scale};
    row.ms_median = 5.1234 * scale;
    row.ms_spread = 0.96 * scale;
    row.frames = 5;
  }
  const std::string text = format_markdown(noisy);
  EXPECT_THAT(text, HasSubstr("| 10 \u00b12 noisy | 100 | 1.00x |"));
  EXPECT_THAT(text, HasSubstr("| 5.1 \u00b11.0 noisy | 200 | 2.000x \u00b10.000 |"));
  EXPECT_THAT(noise_sentence(noisy.rows),
              HasSubstr("the middle half of its frames spans 37 % of the median"));
  for (BenchRow& row : noisy.rows) {
    row.frames = 4;
    row.ms_spread = 0.04;
  }
  EXPECT_THAT(format_markdown(noisy), HasSubstr("| 5.12 \u00b10.04 | 195 | - |"));
}

BenchReport report() {
  BenchReport report;
  report.environment = {{"cpu", "some CPU"}, {"backend", "cpu"}, {"commit", "abc"}};
  report.rows = {row_of_times("3dgs", 0, {8, 8}),  row_of_times("adr", 0, {4, 4}),
                 row_of_times("exact", 0, {2, 2}), row_of_times("3dgs", 1, {9, 9}),
                 row_of_times("adr", 1, {6, 6}),   row_of_times("exact", 1, {3, 3})};
  return report;
}

TEST(BenchRatios, are_written_as_csv_and_json) {
  BenchReport one_round = report();
  for (BenchRow& each : one_round.rows) each.round_ms.pop_back();
  EXPECT_EQ(format_ratios_csv(one_round),
            "scene,camera,mode,pipeline,baseline,ratio,ratio_low,ratio_high,samples\n"
            "scene,camera 0,adr,fast,3dgs,2.0000,,,1\n"
            "scene,camera 1,adr,fast,3dgs,1.5000,,,1\n"
            "scene,,adr,fast,3dgs,1.7321,0.2785,10.7723,2\n"
            "scene,camera 0,exact,fast,3dgs,4.0000,,,1\n"
            "scene,camera 1,exact,fast,3dgs,3.0000,,,1\n"
            "scene,,exact,fast,3dgs,3.4641,0.5570,21.5446,2\n");
  const auto json = nlohmann::ordered_json::parse(format_bench_json(report()));
  EXPECT_EQ(json["baseline"], "3dgs");
  ASSERT_EQ(json["ratios"].size(), 6u);
  EXPECT_EQ(json["ratios"][0]["camera"], "camera 0");
  EXPECT_NEAR(json["ratios"][0]["ratio_low"].get<double>(), 2, 1e-9);
  EXPECT_EQ(json["ratios"][5]["camera"], nullptr);
  EXPECT_EQ(json["ratios"][5]["mode"], "exact");
  EXPECT_NEAR(json["ratios"][5]["ratio"].get<double>(), std::sqrt(12), 1e-9);
  EXPECT_EQ(json["ratios"][5]["samples"], 2);
  const auto again = nlohmann::ordered_json::parse(format_bench_json(parse_bench_report(json)));
  EXPECT_EQ(again, json);
}

TEST(BenchRatios, are_relative_to_the_chosen_baseline_and_then_listed_per_camera) {
  BenchReport chosen = report();
  EXPECT_THAT(format_markdown(chosen), HasSubstr("| FPS | vs 3dgs |"));
  EXPECT_THAT(format_markdown(chosen), Not(HasSubstr("per camera\n")));
  chosen.environment["baseline"] = "adr";
  EXPECT_EQ(baseline_of(chosen), "adr");
  const std::string text = format_markdown(chosen);
  EXPECT_THAT(text, HasSubstr("| FPS | vs adr |"));
  EXPECT_THAT(text, HasSubstr("Ratios are the time of `adr` divided by"));
  EXPECT_THAT(text, HasSubstr("\n### scene: ratios to `adr` per camera\n\n"
                              "| camera | `3dgs` | `exact` |\n|---|---:|---:|\n"
                              "| camera 0 | 0.500x \u00b10.000 | 2.000x \u00b10.000 |\n"
                              "| camera 1 | 0.667x \u00b10.000 | 2.000x \u00b10.000 |\n"));
  EXPECT_THAT(text, HasSubstr("| 2.000x \u00b10.000 | 0 |"));  // exact, over the cameras
  EXPECT_THAT(text, HasSubstr("| 1.00x | 0 |"));               // adr itself
  for (BenchRow& each : chosen.rows) each.mode = "other " + each.mode;
  EXPECT_THAT(format_markdown(chosen), Not(HasSubstr("Ratios")));
}

}  // namespace
}  // namespace qs
