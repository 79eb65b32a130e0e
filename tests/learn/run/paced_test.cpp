// SPDX-License-Identifier: MIT
// Strategy paced: the number of Gaussians, the schedule, and the guard of reserved views.
#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/support/forwarding_model.h"
#include "app/support/training.h"
#include "learn/run/guard.h"
#include "learn/run/strategy.h"
#include "learn/run/train_log.h"
#include "raster/kernel/random.h"
#include "support/pool.h"

namespace qs::train {
namespace {

using test::expect_same;

TrainSettings paced_settings(int iterations, std::size_t gaussians = 0) {
  TrainSettings settings;
  settings.strategy = "paced";
  settings.iterations = iterations;
  settings.max_gaussians = gaussians;
  settings.sh_degree = 0;
  settings.guard = true;
  return settings;
}

struct GrowthCase {
  int iterations;
  std::size_t views, start, target;
  int changes;
};

class PacedGrowth : public testing::TestWithParam<GrowthCase> {};

// The changes of a run, without training between them.
TEST_P(PacedGrowth, the_number_follows_the_line_and_ends_at_the_target) {
  const GrowthCase& c = GetParam();
  const TrainSettings settings = paced_settings(c.iterations, c.target);
  const Strategy& strategy = find_strategy("paced");
  const RunFacts run{.views = c.views, .pace = Pace(c.iterations)};
  ModelState model = ModelState::starting_with(test::ball_of_gaussians(c.start, 1));
  int changes = 0, last = 0;
  for (int iteration = 1; iteration <= c.iterations; ++iteration) {
    if (!strategy.changes_before(settings, iteration, run)) continue;
    const double time = (iteration - 1.0) / c.iterations;
    EXPECT_GT(time, 0.05);
    EXPECT_LE(time, 0.7 + 1.0 / c.iterations);
    const int least = last > 0 ? std::max(100, static_cast<int>(c.views)) : 0;
    EXPECT_GE(iteration - last, time < 0.7 - 1e-9 ? least - 1 : least * 3 / 4) << iteration;
    last = iteration;
    ++changes;
    Plan plan;
    strategy.plan(
        {.settings = settings, .iteration = iteration, .extent = 1, .rates = {}, .run = run},
        facts_of(model), plan);
    model = changed(model, plan);
    const double start = static_cast<double>(c.start), target = static_cast<double>(c.target);
    const double share = std::min(1.0, (time - 0.05) / 0.65);
    const double line = target <= start ? start : start + (target - start) * share;
    EXPECT_EQ(model.size(), static_cast<std::size_t>(line + 1e-5)) << iteration;
  }
  EXPECT_EQ(changes, c.changes);
  EXPECT_EQ(model.size(), std::max(c.start, c.target));
}

INSTANTIATE_TEST_SUITE_P(
    Paced, PacedGrowth,
    testing::Values(GrowthCase{10'000, 84, 100, 2000, 60}, GrowthCase{10'000, 255, 100, 2000, 25},
                    GrowthCase{10'000, 10'000, 100, 300, 1}, GrowthCase{30'000, 84, 50, 777, 60},
                    GrowthCase{30'000, 500, 50, 777, 39}, GrowthCase{1000, 10, 20, 401, 6},
                    GrowthCase{500, 10, 20, 1001, 3}, GrowthCase{100, 10, 20, 60, 1},
                    GrowthCase{20, 3, 20, 90, 1}, GrowthCase{10'000, 84, 300, 300, 60},
                    GrowthCase{10'000, 84, 300, 200, 60}),
    [](const auto& row) {
      return fmt::format("of_{}_iterations_{}_views_to_{}", row.param.iterations, row.param.views,
                         row.param.target);
    });

TEST(Paced, a_corrected_pace_keeps_the_intervals_and_the_target) {
  const std::vector<std::vector<Pace::Row>> paces = {
      {{0, 30'000}, {400, 5000}, {1500, 2500}},
      {{0, 30'000}, {900, 800}, {1000, 3000}},
      {{0, 300}, {100, 30'000}, {5000, 10'000}},
      {{0, 10'000}, {6900, 100}},
  };
  const TrainSettings settings = paced_settings(1, 2000);
  const Strategy& strategy = find_strategy("paced");
  for (const std::vector<Pace::Row>& rows : paces) {
    const RunFacts run{.views = 10, .pace = Pace(rows)};
    ModelState model = ModelState::starting_with(test::ball_of_gaussians(10, 1));
    int last = 0;
    for (int iteration = 1; iteration <= run.pace.end(); ++iteration) {
      if (!strategy.changes_before(settings, iteration, run)) continue;
      const bool ends = run.pace.time(iteration - 1) >= 0.7 - 1e-9;
      EXPECT_TRUE(ends || last == 0 || iteration - last >= 99) << iteration << " after " << last;
      last = iteration;
      Plan plan;
      strategy.plan({settings, iteration, 1, {}, 1, run}, facts_of(model), plan);
      model = changed(model, plan);
    }
    EXPECT_EQ(model.size(), 2000u);
  }
}

TEST(Paced, the_target_is_a_gaussian_for_every_200_pixels_of_the_photographs) {
  const TrainSettings settings = paced_settings(1000);
  const Strategy& strategy = find_strategy("paced");
  const RunFacts run{.views = 10, .pixels = 20'099, .pace = Pace(1000)};
  const ModelState model = ModelState::starting_with(test::ball_of_gaussians(40, 1));
  Plan plan;
  for (int iteration = 700; iteration <= 702; ++iteration)
    if (strategy.changes_before(settings, iteration, run))
      strategy.plan({settings, iteration, 1, {}, 1, run}, facts_of(model), plan);
  EXPECT_EQ(plan.growth.initial, 40u);
  EXPECT_EQ(plan.growth.budget, 100u);
}

TEST(Paced, a_run_has_70_iterations_for_each_view_between_two_limits) {
  const std::pair<std::size_t, int> rows[] = {{0, 3000},     {1, 3000},        {42, 3000},
                                              {43, 3010},    {84, 5880},       {428, 29'960},
                                              {429, 30'000}, {100'000, 30'000}};
  for (const auto& [views, iterations] : rows) EXPECT_EQ(paced_iterations(views), iterations);
  EXPECT_STREQ(default_strategy().name, "paced");
}

TEST(Paced, rates_follow_the_run_and_fall_at_its_end) {
  for (const int n : {100, 1000, 30'000}) {
    const TrainSettings settings = paced_settings(n);
    const Strategy& strategy = find_strategy("paced");
    const auto rates = [&](double time, int stopped_after = 0) {
      const RunFacts run{.views = 10, .pace = Pace(n), .stopped_after = stopped_after};
      const int iteration = static_cast<int>(std::lround(time * n));
      return strategy.step({settings, iteration, 2, rates_at(iteration, 2, 0.025), 1, run}).rates;
    };
    EXPECT_NEAR(rates(0).mean, 2 * 1.6e-4, 1e-9) << n;
    EXPECT_NEAR(rates(0.5).mean, 2 * 1.6e-4 / std::sqrt(10.0), 1e-9) << n;
    EXPECT_NEAR(rates(1).mean, 2 * 1.6e-5, 1e-9) << n;
    EXPECT_NEAR(rates(0.7).opacity, 0.025, 1e-9) << n;
    EXPECT_NEAR(rates(1).opacity, 0.0025, 1e-9) << n;
    EXPECT_NEAR(rates(1).log_scale, 5e-4, 1e-9) << n;
    EXPECT_NEAR(rates(0.85).sh_dc, 2.5e-3 / std::sqrt(10.0), 1e-9) << n;
    EXPECT_NEAR(rates(0.7, n / 2).rotation, 1e-3 * std::pow(0.1, 0.4), 1e-9) << "after the guard";
    EXPECT_NEAR(rates(1, n / 2).rotation, 1e-4, 1e-9) << n;
  }
}

// The guard.

std::vector<GuardRow> rows_of(const std::vector<double>& reserved,
                              const std::vector<double>& trained) {
  std::vector<GuardRow> rows;
  for (std::size_t i = 0; i < reserved.size(); ++i)
    rows.push_back({static_cast<int>(i + 1) * 25, reserved[i], trained[i]});
  return rows;
}

TEST(Guard, stops_growth_if_the_reserved_views_get_worse_while_others_get_better) {
  const std::vector<double> up = {20, 21, 22, 23, 24, 25, 26, 27}, flat(8, 20);
  const struct {
    const char* what;
    std::vector<double> reserved, trained;
    int stopped;
  } cases[] = {
      {"better", {20, 21, 22, 23, 24, 25, 26, 27}, up, 0},
      {"a little worse", {20, 21, 22, 22, 22, 21.91, 21.9, 21.9}, up, 0},
      {"worse", {20, 21, 22, 22, 22, 21, 21, 21}, up, 200},
      {"worse only once", {20, 21, 22, 22, 22, 21.8, 22, 22}, up, 0},
      {"worse twice", {20, 21, 22, 22, 22, 22, 21, 21}, up, 0},
      {"lower behind halvings", {20, 21, 18, 22, 18, 18, 22.5, 18}, up, 0},
      {"all are worse", {20, 21, 22, 22, 22, 21, 21, 21}, {20, 21, 22, 22, 22, 21, 21, 21}, 0},
      {"better again", {20, 20, 20, 19, 19, 19, 26, 27}, up, 150},
      {"two measurements", {20, 10}, {20, 30}, 0},
      {"worse from the start", {20, 19, 18, 17, 16, 15, 14, 13}, up, 100},
      {"the trained stay", {20, 21, 22, 22, 22, 21, 21, 21}, flat, 0},
  };
  for (const auto& c : cases) {
    const Guard guard(40, 0, rows_of(c.reserved, c.trained));
    EXPECT_EQ(guard.stopped_after(), c.stopped) << c.what;
    EXPECT_TRUE(guard.trains_all(Pace(1000), 801)) << c.what;
    EXPECT_FALSE(guard.trains_all(Pace(1000), 800)) << c.what;
    EXPECT_THAT(guard.verdict(),
                testing::HasSubstr(c.stopped == 0 ? "did not get worse" : "growth stopped"))
        << c.what;
  }
}

TEST(Guard, reserves_a_twentieth_but_three_and_no_more_than_a_quarter) {
  const std::pair<std::size_t, std::size_t> cases[] = {{0, 0},  {1, 0},    {3, 0},    {4, 1},
                                                       {8, 2},  {12, 3},   {43, 3},   {60, 3},
                                                       {84, 4}, {255, 12}, {1000, 50}};
  std::set<std::vector<std::size_t>> choices;
  for (const auto& [views, reserved] : cases) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const Guard guard(views, seed, {});
      ASSERT_EQ(guard.reserved().size(), reserved) << views;
      EXPECT_EQ(guard.trained().size(), views - reserved) << views;
      std::set<std::size_t> all(guard.trained().begin(), guard.trained().end());
      for (const std::size_t beside : guard.neighbours()) EXPECT_TRUE(all.contains(beside));
      all.insert(guard.reserved().begin(), guard.reserved().end());
      EXPECT_EQ(all.size(), views);
      if (views == 84) choices.insert(guard.reserved());
    }
  }
  EXPECT_GT(choices.size(), 3u) << "seeds choose other views";
}

TEST(Guard, measures_every_fortieth_after_the_first_tenth_until_the_views_are_trained) {
  Guard guard(40, 0, {});
  std::vector<int> due;
  for (int i = 1; i <= 1000; ++i) {
    if (!guard.due(Pace(1000), i)) continue;
    due.push_back(i);
    guard.add({i, 20.0 + i, 20.0 + i});
    EXPECT_FALSE(guard.due(Pace(1000), i)) << "it was measured";
  }
  EXPECT_EQ(due.size(), 28u);
  EXPECT_EQ(due.front(), 125);
  EXPECT_EQ(due.back(), 800);
  EXPECT_FALSE(Guard().due(Pace(1000), 500)) << "no views are reserved";
}

const DataSet& many_views() {
  static const DataSet data = test::data_set_of(test::ball_of_gaussians(40, 1), 22);
  return data;
}

/// Notes the views that are trained and counted, by their cameras' names.
class NotingViews : public test::ForwardingModel {
 public:
  std::vector<std::string> trained, counted;

  void forward(const Camera& camera, const RenderSettings& settings,
               std::stop_token stop) override {
    drawn_ = camera.name;
    ForwardingModel::forward(camera, settings, std::move(stop));
  }
  void count_errors(std::optional<std::size_t> number, const Photograph& photograph) override {
    counted.push_back(drawn_);
    ForwardingModel::count_errors(number, photograph);
  }
  void backward(const BackwardOrder& order) override {
    trained.push_back(drawn_);
    ForwardingModel::backward(order);
  }

 private:
  std::string drawn_;
};

TEST(Guard, reserved_views_are_not_trained_before_four_fifths_of_the_run) {
  const DataSet& data = many_views();
  const TrainSettings settings = paced_settings(300, 50);
  auto model = std::make_unique<NotingViews>();
  NotingViews& noting = *model;
  model->set_state(ModelState::starting_with(test::ball_of_gaussians(40, 2)));
  Trainer trainer(settings, data, std::move(model), test::pool());
  while (trainer.iteration() < settings.iterations) trainer.step();
  ASSERT_EQ(trainer.guard().stopped_after(), 0);
  ASSERT_EQ(noting.trained.size(), 300u);
  ASSERT_EQ(trainer.guard().reserved().size(), 3u);
  const std::set<std::string> before(noting.trained.begin(), noting.trained.begin() + 240),
      after(noting.trained.begin() + 240, noting.trained.end());
  EXPECT_EQ(before.size(), trainer.guard().trained().size());
  EXPECT_EQ(after.size(), data.training.size());
  for (const std::size_t view : trainer.guard().reserved())
    EXPECT_FALSE(before.contains(data.training[view].camera.name));
}

// Photographs with squares of random colours, which a model can only remember.
DataSet noisy_views() {
  constexpr int kSquare = 8;
  DataSet data = test::data_set_of(test::ball_of_gaussians(40, 1), 8);
  const Random random = Random::of(0, RandomUse::noise, 0);
  for (std::size_t v = 0; v < data.training.size(); ++v) {
    PhotographView& view = data.training[v];
    for (std::size_t i = 0; i < view.rgb.size(); ++i) {
      const std::size_t x = i / 3 % 64 / kSquare, y = i / 3 / 64 / kSquare;
      const double noise = 100 * (random.uniform(((v * 64 + y) * 64 + x) * 3 + i % 3) - 0.5);
      view.rgb[i] = static_cast<std::uint8_t>(std::clamp(view.rgb[i] + noise, 0.0, 255.0));
    }
  }
  return data;
}

TEST(Guard, stops_the_growth_of_a_run_that_remembers_its_few_photographs) {
  const DataSet data = noisy_views();
  TrainSettings settings = paced_settings(800, 2000);
  Trainer trainer = test::trainer_on(Backend::cpu, settings, data,
                                     ModelState::starting_with(test::ball_of_gaussians(40, 1)));
  std::size_t stopped_with = 0;
  while (trainer.iteration() < settings.iterations) {
    const std::size_t before = trainer.gaussians();
    trainer.step();
    if (trainer.guard().stopped_after() == 0) continue;
    if (stopped_with == 0) stopped_with = before;
    ASSERT_EQ(trainer.gaussians(), stopped_with) << "growth goes on";
  }
  EXPECT_GT(trainer.guard().stopped_after(), 0);
  EXPECT_LT(trainer.gaussians(), 2000u);
}

/// The model at the end of a run that was interrupted after `parts`, with the log's record of the
/// guard between the parts.
ModelState trained_in_parts(const DataSet& data, const TrainSettings& settings,
                            const std::vector<int>& parts, int threads) {
  ModelState state = ModelState::starting_with(test::ball_of_gaussians(40, 1));
  TrainLog log;
  for (const int until : parts) {
    ThreadPool own(threads);
    auto model = make_training_model(Backend::cpu, own);
    model->set_state(std::move(state));
    Trainer trainer(settings, data, std::move(model), own, log.guard);
    while (trainer.iteration() < until) trainer.step();
    log.guard = trainer.guard().rows();
    log = log_of(nlohmann::ordered_json::parse(log_json(log).dump()));
    state = trainer.model();
  }
  return state;
}

TEST(Paced, a_run_in_parts_and_with_other_threads_gives_the_same_bits) {
  const TrainSettings grows = paced_settings(400, 120), stops = paced_settings(800, 2000);
  const ModelState grown = trained_in_parts(many_views(), grows, {400}, 2);
  EXPECT_EQ(grown.size(), 120u);
  expect_same(trained_in_parts(many_views(), grows, {130, 131, 281, 400}, 1), grown);
  const DataSet noisy = noisy_views();
  const ModelState stopped = trained_in_parts(noisy, stops, {800}, 2);
  EXPECT_LT(stopped.size(), 2000u) << "the guard stopped growth";
  expect_same(trained_in_parts(noisy, stops, {200, 201, 400, 600, 800}, 1), stopped);
}

TEST(Paced, decays_clear_all_moments) {
  const TrainSettings settings = paced_settings(1000, 50);
  const Strategy& strategy = find_strategy("paced");
  const RunFacts run{.views = 10, .pace = Pace(1000)};
  ModelState model = ModelState::starting_with(test::ball_of_gaussians(40, 1));
  for (glm::vec3& value : model.adam.second.sh) value = glm::vec3(7);
  for (float& value : model.adam.first.opacity_logits) value = 7;
  Plan plan;
  strategy.plan({settings, 701, 1, {}, 1, run}, facts_of(model), plan);
  const ModelState next = changed(model, plan);
  EXPECT_THAT(next.adam.second.sh, testing::Each(glm::vec3(0)));
  EXPECT_THAT(next.adam.first.opacity_logits, testing::Each(0.0f));
}

}  // namespace
}  // namespace qs::train
