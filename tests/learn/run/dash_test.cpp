// SPDX-License-Identifier: MIT
// Strategy dash and training with reduced photographs, against DashGaussian's published rules.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/support/forwarding_model.h"
#include "app/support/training.h"
#include "learn/run/density_rules.h"
#include "learn/run/schedule.h"
#include "learn/run/trainer.h"
#include "support/pool.h"

namespace qs::train {
namespace {

using test::pool;
using testing::ElementsAre;

TrainSettings dash_settings(int iterations = 30'000) {
  TrainSettings settings;
  settings.strategy = "dash";
  settings.iterations = iterations;
  settings.sh_degree = 0;
  settings.reduced_photographs = true;
  return settings;
}

// Facts of n Gaussians, of which every 50th is nearly transparent and the first half wants to be
// cloned.
GaussianFacts facts_of_number(std::size_t n, const GrowthState& growth) {
  ModelState state = ModelState::starting_with(test::ball_of_gaussians(n, 1));
  state.growth = growth;
  for (std::size_t i = 0; i < n; ++i) {
    state.parameters.opacity_logits[i] = i % 50 == 49 ? -8.0f : 0.0f;
    state.parameters.log_scales[i] = glm::vec3(-9);
    state.density.views[i] = 1;
    state.density.sums[i] = i < n / 2 ? 3e-4f : 1e-4f;
  }
  return facts_of(state);
}

struct Change {
  std::size_t gaussians;
  std::uint64_t budget;
};

Change changed_after(int iteration, int factor, std::size_t n, const GrowthState& growth,
                     const TrainSettings& settings = dash_settings()) {
  Plan plan;
  IterationContext context{settings, iteration + 1, 1, {}, factor};
  find_strategy("dash").plan(context, facts_of_number(n, growth), plan);
  return {plan.size(), plan.growth.budget};
}

TEST(Dash, the_number_grows_as_published) {
  // 2 % are removed; at most the wanted number is left.
  const Change first = changed_after(600, 7, 10'000, {});
  EXPECT_EQ(first.gaussians, 11'065u);
  EXPECT_EQ(first.budget, 54'000u - (5000 - 4900)) << "nearly transparent ones do not count";
  const Change second = changed_after(700, 4, 11'065, {10'000, 54'000});
  EXPECT_EQ(second.gaussians, 13'278u) << "a fifth more at most";
  EXPECT_EQ(second.budget, 52'920u + 5532 - 110);
}

TEST(Dash, the_last_changes_use_the_whole_budget) {
  const auto most = [](int iteration, int factor) {
    return changed_after(iteration, factor, 10'000, {1000, 9800}).gaussians;
  };
  EXPECT_EQ(most(26'800, 2), 10'000u) << "as many as were removed";
  EXPECT_EQ(most(26'900, 2), 10'800u);
}

TEST(Dash, only_those_that_want_to_grow_are_added) {
  EXPECT_EQ(changed_after(600, 1, 100, {}).gaussians, 98u + 22u) << "a fifth more";
  ModelState state = ModelState::starting_with(test::ball_of_gaussians(10, 1));
  state.density.views.assign(10, 1);
  state.density.sums.assign(10, 1.9e-4f);
  state.density.sums[3] = 2.1e-4f;
  Plan plan;
  const TrainSettings settings = dash_settings();
  find_strategy("dash").plan({settings, 601, 1e9, {}, 1}, facts_of(state), plan);
  ASSERT_EQ(plan.size(), 11u);
  EXPECT_EQ(plan.sources[10], 3u);
}

TEST(Dash, removes_transparent_gaussians_but_no_large_ones) {
  ModelState state = ModelState::starting_with(test::ball_of_gaussians(4, 1));
  state.parameters.opacity_logits = {-5.5f, -5.2f, 0, 0};
  state.parameters.log_scales[2] = glm::vec3(9);
  Plan plan;
  const TrainSettings settings = dash_settings();
  find_strategy("dash").plan({settings, 4001, 1, {}, 1}, facts_of(state), plan);
  EXPECT_THAT(plan.sources, ElementsAre(1u, 2u, 3u));
}

TEST(Dash, changes_and_resets_fit_into_the_run) {
  const auto changes = [](int iterations) {
    TrainSettings settings = dash_settings(iterations);
    std::vector<int> resets;
    int first = 0, last = 0;
    for (int after = 0; after <= iterations; ++after) {
      if (!find_strategy("dash").changes_before(settings, after + 1)) continue;
      if (first == 0) first = after;
      last = after;
      Plan plan;
      find_strategy("dash").plan({settings, after + 1, 1, {}, 1}, facts_of_number(3, {}), plan);
      if (plan.clears_opacity_moments) resets.push_back(after);
    }
    return std::tuple(first, last, resets);
  };
  EXPECT_EQ(changes(30'000),
            std::tuple(600, 26'900,
                       std::vector{3000, 6000, 9000, 12'000, 15'000, 18'000, 21'000, 24'000}));
  EXPECT_EQ(changes(7000), std::tuple(600, 6200, std::vector{3000}));
  EXPECT_EQ(changes(500), std::tuple(0, 0, std::vector<int>{}));
}

TEST(Dash, steps_are_taken_except_in_front_of_a_change) {
  const TrainSettings settings = dash_settings();
  const auto order = [&](int iteration) {
    return find_strategy("dash").step({settings, iteration, 1, {}, 1});
  };
  EXPECT_TRUE(order(599).moves);
  EXPECT_FALSE(order(600).moves);
  EXPECT_FALSE(order(26'900).moves);
  EXPECT_TRUE(order(27'000).moves);
  EXPECT_TRUE(order(26'999).counts_density);
  EXPECT_FALSE(order(27'000).counts_density);
}

TEST(Dash, rate_of_the_means_falls_when_details_come) {
  EXPECT_NEAR(rates_at(15'000, 1, 0, {3271, true}).mean, 2.120783949e-5, 1e-14);
  EXPECT_NEAR(rates_at(3271, 1, 0, {3271, true}).mean, 1.6e-4, 1e-12);
  EXPECT_NEAR(rates_at(1, 1, 0, {3271, true}).mean, 1.6e-4, 1e-12);
  EXPECT_NEAR(rates_at(30'000, 1, 0, {3271, true}).mean, 1.6e-6, 1e-14);
  EXPECT_EQ(rates_at(3270, 1, 0, {3271, false}).mean, 0) << "as in June 2025";
  EXPECT_NEAR(rates_at(3271, 1, 0, {3271, false}).mean, 1.6e-4, 1e-12);
  EXPECT_NEAR(rates_at(90'000, 1, 0, {40'000, true}).mean, 1.6e-6, 1e-14);
}

TEST(Dash, a_run_cannot_be_continued_to_another_end) {
  TrainSettings longer = dash_settings(40'000);
  EXPECT_EQ(differences_of(dash_settings(), longer), "iterations");
  longer.strategy = "adc";
  TrainSettings shorter = longer;
  shorter.iterations = 10;
  EXPECT_EQ(differences_of(shorter, longer), "iterations") << "its photographs are reduced";
  shorter.reduced_photographs = longer.reduced_photographs = false;
  EXPECT_EQ(differences_of(shorter, longer), "");
}

TEST(Dash, settings_survive_json) {
  TrainSettings settings = dash_settings();
  settings.dash_of_paper = true;
  const TrainSettings read = settings_of(settings_json(settings));
  EXPECT_TRUE(read.reduced_photographs);
  EXPECT_TRUE(read.dash_of_paper);
}

TEST(Settings, of_older_runs_without_the_key_extent_had_the_published_one) {
  nlohmann::ordered_json json = settings_json(TrainSettings());
  EXPECT_FALSE(settings_of(json).published_extent);
  json["extent"] = "published";
  EXPECT_TRUE(settings_of(json).published_extent);
  json.erase("extent");
  EXPECT_TRUE(settings_of(json).published_extent);
}

// A model that notes the sizes of the views that it draws.
class NotingModel final : public test::ForwardingModel {
 public:
  std::vector<int> widths;
  int forgotten = 0;

  void forward(const Camera& camera, const RenderSettings& settings,
               std::stop_token stop) override {
    widths.push_back(camera.width);
    ForwardingModel::forward(camera, settings, std::move(stop));
  }
  void forget_photographs() override { ++forgotten; }
};

TEST(Dash, training_begins_with_reduced_photographs_and_ends_with_whole_ones) {
  const DataSet data = test::data_set_of(test::ball_of_gaussians(30, 1), 3);
  const int width = data.training.front().camera.width;
  for (const char* strategy : {"dash", "adc", "fastgs"}) {
    TrainSettings settings = dash_settings(800);
    settings.strategy = strategy;
    auto model = std::make_unique<NotingModel>();
    NotingModel& noting = *model;
    model->set_state(ModelState::starting_with(test::ball_of_gaussians(30, 2)));
    Trainer trainer(settings, data, std::move(model), pool());
    for (int i = 0; i < settings.iterations; ++i) trainer.step();
    EXPECT_LT(noting.widths.front(), width / 2) << strategy;
    EXPECT_TRUE(std::is_sorted(noting.widths.begin(), noting.widths.end())) << strategy;
    EXPECT_EQ(noting.widths.back(), width) << strategy;
    EXPECT_GE(noting.forgotten, 2) << "copies of another size must go; " << strategy;
  }
}

TEST(Dash, a_run_in_two_parts_gives_the_same_bits) {
  const DataSet data = test::data_set_of(test::ball_of_gaussians(60, 1), 3);
  const TrainSettings settings = dash_settings(900);
  const auto trained = [&](ModelState state, int until, int threads) {
    ThreadPool own(threads);
    auto model = make_training_model(Backend::cpu, own);
    model->set_state(std::move(state));
    Trainer trainer(settings, data, std::move(model), own);
    while (trainer.iteration() < until) trainer.step();
    return trainer.model();
  };
  const ModelState start = ModelState::starting_with(test::ball_of_gaussians(60, 2));
  const ModelState whole = trained(start, 810, 2);
  EXPECT_GT(whole.growth.budget, 0u);
  test::expect_same(trained(trained(start, 650, 1), 810, 1), whole);
}

}  // namespace
}  // namespace qs::train
