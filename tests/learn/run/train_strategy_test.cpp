// SPDX-License-Identifier: MIT
// The strategies of training, against their published rules.
#include <cmath>

#include <gtest/gtest.h>

#include "app/support/training.h"
#include "learn/run/initial.h"
#include "learn/run/schedule.h"
#include "learn/run/strategy.h"
#include "support/error_of.h"
#include "support/pool.h"

namespace qs::train {
namespace {

using test::pool;

/// A model after iteration `last`, and the result of the strategy's plan.
struct Case {
  TrainSettings settings;
  ModelState model;
  PixelCounts counts;

  explicit Case(std::size_t gaussians, const char* strategy = "adc") {
    settings.sh_degree = 0;
    settings.strategy = strategy;
    Parameters parameters = test::ball_of_gaussians(gaussians, 1);
    for (float& logit : parameters.opacity_logits) logit = 0;
    for (glm::vec3& log_scale : parameters.log_scales)
      log_scale = glm::vec3(std::log(0.02f), std::log(0.005f), std::log(0.005f));
    if (find_strategy(strategy).has_masks) parameters = with_masks(std::move(parameters));
    model = ModelState::starting_with(std::move(parameters));
    for (auto* moments : {&model.adam.first, &model.adam.second}) {
      for (glm::vec3& value : moments->means) value = glm::vec3(7);
      for (float& value : moments->opacity_logits) value = 7;
    }
  }
  void prepare_after(int last, double extent) {
    const Strategy& strategy = find_strategy(settings.strategy);
    if (!strategy.changes_before(settings, last + 1)) return;
    GaussianFacts facts = facts_of(model);
    facts.counts = counts;
    Plan plan;
    strategy.plan({settings, last + 1, extent, {}}, facts, plan);
    model = changed(model, plan);
  }
  /// Gaussian i has this mean gradient on the image.
  void set_gradient(std::size_t i, float gradient) {
    model.density.sums[i] = 3 * gradient;
    model.density.views[i] = 3;
  }
  void set_absolute_gradient(std::size_t i, float gradient) {
    model.density.absolute.resize(model.size());
    model.density.absolute[i] = 3 * gradient;
    model.density.views[i] = 3;
  }
  /// 3 % of the pixels of Gaussian i are flagged, and of other Gaussians a little less.
  void flag(std::size_t i) {
    counts.blended.resize(model.size(), 1000);
    counts.flagged.resize(model.size(), 29);
    counts.flagged[i] = 30;
  }
};

TEST(TrainAdc, clones_small_gaussians_that_want_to_move) {
  Case c(4);
  c.set_gradient(1, 2.1e-4f);
  c.set_gradient(2, 1.9e-4f);
  const Parameters before = c.model.parameters;
  c.prepare_after(600, 10);  // small: up to 0.1
  ASSERT_EQ(c.model.size(), 5u);
  EXPECT_EQ(c.model.parameters.means[4], before.means[1]);
  EXPECT_EQ(c.model.parameters.log_scales[4], before.log_scales[1]);
  EXPECT_EQ(c.model.adam.first.means[4], glm::vec3(0)) << "new Gaussians have no moments";
  EXPECT_EQ(c.model.adam.first.means[1], glm::vec3(7)) << "old ones keep theirs";
  EXPECT_EQ(c.model.density.mean(1), 0) << "the statistics start again";
}

TEST(TrainAdc, splits_large_gaussians_into_two_smaller_ones_inside_of_them) {
  Case c(4);
  c.set_gradient(1, 2.1e-4f);
  const Parameters before = c.model.parameters;
  c.prepare_after(600, 1);  // small: up to 0.01
  ASSERT_EQ(c.model.size(), 5u);
  EXPECT_EQ(c.model.parameters.means[0], before.means[0]);
  EXPECT_EQ(c.model.parameters.means[1], before.means[2]) << "the old one is gone";
  for (const std::size_t child : {3u, 4u}) {
    EXPECT_LT(glm::distance(c.model.parameters.means[child], before.means[1]), 5 * 0.02);
    EXPECT_NE(c.model.parameters.means[child], before.means[1]);
    EXPECT_FLOAT_EQ(c.model.parameters.log_scales[child].x, std::log(0.02f / 1.6f));
    EXPECT_EQ(c.model.adam.second.means[child], glm::vec3(0));
  }
  EXPECT_NE(c.model.parameters.means[3], c.model.parameters.means[4]);
}

TEST(TrainAdc, children_of_a_split_are_distributed_like_their_parent) {
  constexpr std::size_t kCount = 4000;
  Case c(kCount);
  auto& p = c.model.parameters;
  for (std::size_t i = 0; i < kCount; ++i) {
    p.means[i] = glm::vec3(1, 2, 3);
    p.rotations[i] = glm::quat(2, 0, 0, 2);  // x turns to y
    p.log_scales[i] = glm::vec3(std::log(0.4f), std::log(0.2f), std::log(0.1f));
    c.set_gradient(i, 1);
  }
  c.prepare_after(600, 1);
  ASSERT_EQ(c.model.size(), 2 * kCount);
  glm::dvec3 mean(0), variance(0);
  for (const glm::vec3& m : p.means) mean += glm::dvec3(m) / double(2 * kCount);
  for (const glm::vec3& m : p.means) {
    const glm::dvec3 d = glm::dvec3(m) - mean;
    variance += d * d / double(2 * kCount);
  }
  EXPECT_LT(glm::distance(mean, glm::dvec3(1, 2, 3)), 0.02);
  EXPECT_NEAR(std::sqrt(variance.x), 0.2, 0.01);
  EXPECT_NEAR(std::sqrt(variance.y), 0.4, 0.02);
  EXPECT_NEAR(std::sqrt(variance.z), 0.1, 0.005);
}

TEST(TrainAdc, removes_transparent_gaussians_and_after_the_first_reset_huge_ones) {
  const auto sizes = [](int last) {
    Case c(5);
    c.model.parameters.opacity_logits[0] = -5.5f;  // opacity 0.0041
    c.model.parameters.opacity_logits[1] = -5.2f;  // opacity 0.0055
    c.model.parameters.log_scales[2].z = std::log(0.11f);
    c.prepare_after(last, 1);
    return c.model.size();
  };
  EXPECT_EQ(sizes(600), 4u);
  EXPECT_EQ(sizes(3000), 4u);
  EXPECT_EQ(sizes(3100), 3u);
  EXPECT_EQ(sizes(601), 5u) << "every 100 iterations";
  EXPECT_EQ(sizes(500), 5u) << "from 600";
  EXPECT_EQ(sizes(14'900), 3u);
  EXPECT_EQ(sizes(15'000), 5u) << "up to 14,900";
}

TEST(TrainAdc, resets_opacities_and_their_moments_every_3000_iterations_up_to_12000) {
  for (const auto& [last, white, resets] : {std::tuple{3000, false, true},
                                            {12'000, false, true},
                                            {15'000, false, false},
                                            {500, false, false},
                                            {500, true, true},
                                            {0, false, false}}) {
    Case c(2);
    c.model.parameters.opacity_logits[1] = -5;  // below 0.01 it stays
    if (white) c.settings.background = glm::vec3(1);
    c.prepare_after(last, 1);
    EXPECT_NEAR(opacity(c.model.parameters, 0), resets ? 0.01 : 0.5, 1e-6) << last;
    EXPECT_EQ(c.model.parameters.opacity_logits[1], -5) << last;
    EXPECT_EQ(c.model.adam.first.opacity_logits[0], resets ? 0 : 7) << last;
    EXPECT_EQ(c.model.adam.first.means[0], glm::vec3(7)) << last;
  }
}

TEST(TrainAdc, keeps_to_the_limit_and_prefers_the_largest_gradients) {
  Case c(4);
  c.settings.max_gaussians = 5;
  c.set_gradient(0, 3e-4f);
  c.set_gradient(3, 5e-4f);
  const Parameters before = c.model.parameters;
  c.prepare_after(600, 10);
  ASSERT_EQ(c.model.size(), 5u);
  EXPECT_EQ(c.model.parameters.means[4], before.means[3]);
}

TEST(TrainAdc, splits_by_absolute_gradients_if_they_are_chosen) {
  for (const bool chosen : {false, true}) {
    Case c(4);
    c.settings.absolute_gradients = chosen;
    for (std::size_t i = 0; i < 4; ++i) c.set_gradient(i, i == 0 ? 2.1e-4f : 1e-4f);
    c.set_absolute_gradient(1, 4.1e-4f);
    c.set_absolute_gradient(2, 3.9e-4f);
    const Parameters before = c.model.parameters;
    c.prepare_after(600, 1);  // all are large
    ASSERT_EQ(c.model.size(), 5u);
    EXPECT_EQ(c.model.parameters.means[0], before.means[chosen ? 0 : 1]) << "the other was split";
    EXPECT_EQ(find_strategy("adc").absolute_gradients(c.settings), chosen);
  }
}

TEST(TrainFinalPrunes, remove_faint_gaussians_after_the_strategys_own_changes) {
  for (const char* strategy : {"adc", "mcmc", "fastgs"}) {
    const bool always = std::string_view(strategy) == "fastgs";
    const int first = std::string_view(strategy) == "mcmc" ? 27'000 : 18'000;
    for (const bool chosen : {false, true}) {
      for (int last = 15'000; last <= 33'000; last += 1500) {
        Case c(3, strategy);
        c.settings.final_prunes = chosen;
        c.settings.max_gaussians = 3;
        c.model.parameters.opacity_logits = {-2.2f, -2.1f, 2};  // opacities 0.0998, 0.109, 0.88
        c.set_gradient(0, 1e-4f);
        const bool due = (always || chosen) && last >= first && last <= 27'000 && last % 3000 == 0;
        c.prepare_after(last, 1);
        EXPECT_EQ(c.model.size(), due ? 2u : 3u) << strategy << ", " << last;
        EXPECT_EQ(c.model.density.sums.size(), c.model.size());
        EXPECT_EQ(
            find_strategy(strategy).step({c.settings, last, 1, rates_at(last, 1, 5e-2)}).moves,
            !due && !(std::string_view(strategy) == "mcmc" && last < 25'000))
            << strategy << ", " << last;
      }
    }
  }
}

TEST(TrainFastgs, clones_and_splits_only_gaussians_whose_pixels_are_wrong) {
  for (const bool many : {false, true}) {
    for (const double extent : {50.0, 1.0}) {  // cloned: up to 0.25; split: above 0.005
      Case c(4, "fastgs");
      c.settings.many_gaussians = many;
      for (std::size_t i = 0; i < 4; ++i) {
        c.set_gradient(i, 2.1e-4f);
        c.set_absolute_gradient(i, many ? 3.1e-4f : 7.1e-4f);
      }
      c.flag(2);
      const Parameters before = c.model.parameters;
      c.prepare_after(1000, extent);
      ASSERT_EQ(c.model.size(), 5u);
      if (extent > 1) {
        EXPECT_EQ(c.model.parameters.means[4], before.means[2]);
      } else {
        EXPECT_EQ(c.model.parameters.means[2], before.means[3]) << "the split one is gone";
        EXPECT_FLOAT_EQ(c.model.parameters.log_scales[4].x, std::log(0.02f / 1.6f));
      }
    }
  }
}

TEST(TrainFastgs, needs_a_gradient_above_the_threshold_of_the_chosen_amount) {
  for (const auto& [many, gradient, adds] : {std::tuple{false, 6.9e-4f, false},
                                             {false, 7.1e-4f, true},
                                             {true, 2.9e-4f, false},
                                             {true, 3.1e-4f, true}}) {
    Case c(4, "fastgs");
    c.settings.many_gaussians = many;
    c.set_absolute_gradient(1, gradient);
    c.flag(1);
    c.prepare_after(1000, 1);
    EXPECT_EQ(c.model.size(), adds ? 5u : 4u) << many << ", " << gradient;
  }
}

TEST(TrainFastgs, changes_every_500_iterations_after_counting_ten_views) {
  const Strategy& fastgs = find_strategy("fastgs");
  for (const auto& [last, changes] : {std::pair{500, false},
                                      {600, false},
                                      {1000, true},
                                      {14'500, true},
                                      {14'900, false},
                                      {15'000, false}}) {
    for (const bool many : {false, true}) {
      TrainSettings settings;
      settings.many_gaussians = many;
      EXPECT_EQ(fastgs.scored_views(settings, last + 1), changes ? 10 : 0) << many << ", " << last;
      EXPECT_EQ(fastgs.changes_before(settings, last + 1), changes) << many << ", " << last;
      EXPECT_EQ(fastgs.step({settings, last, 1, {}}).moves, !changes) << many << ", " << last;
    }
  }
}

TEST(TrainFastgs, steps_seldom_with_sums_of_gradients_if_they_are_chosen) {
  const Strategy& fastgs = find_strategy("fastgs");
  TrainSettings settings;
  EXPECT_FALSE(fastgs.step({settings, 16, 1, {}}).sums);
  settings.sum_gradients = true;
  for (const auto& [iteration, moves, rest_moves] : {std::tuple{15, true, false},
                                                     {16, true, true},
                                                     {1000, false, false},
                                                     {14'992, true, true},
                                                     {15'007, false, false},
                                                     {15'008, true, true},
                                                     {15'024, false, false},
                                                     {20'000, true, true},
                                                     {20'032, true, true},
                                                     {20'064, false, false},
                                                     {20'096, true, true}}) {
    const StepOrder order = fastgs.step({settings, iteration, 1, {}});
    EXPECT_TRUE(order.sums);
    EXPECT_EQ(order.moves, moves) << iteration;
    EXPECT_EQ(order.moves && !order.rest_waits, rest_moves) << iteration;
  }
}

TEST(TrainFastgs, limits_opacities_after_a_change_and_resets_them_every_3000_iterations) {
  for (const auto& [last, opacity_after] : {std::pair{1000, 0.8}, {3000, 0.01}, {15'500, 0.95}}) {
    Case c(2, "fastgs");
    c.model.parameters.opacity_logits[0] = std::log(0.95f / 0.05f);
    c.prepare_after(last, 1);
    EXPECT_NEAR(opacity(c.model.parameters, 0), opacity_after, 1e-6) << last;
    EXPECT_EQ(c.model.adam.first.opacity_logits[1], last > 15'000 ? 7 : 0) << last;
  }
}

TEST(TrainFastgs, keeps_to_the_limit_and_adds_nothing_without_counts) {
  Case c(4, "fastgs");
  c.settings.max_gaussians = 4;
  c.set_absolute_gradient(1, 1);
  c.flag(1);
  c.prepare_after(1000, 1);
  EXPECT_EQ(c.model.size(), 4u);
  c.settings.max_gaussians = 0;
  c.counts = {};
  c.prepare_after(1500, 1);
  EXPECT_EQ(c.model.size(), 4u) << "nothing is known to be wrong";
}

TEST(TrainMcmc, copies_share_the_opacity_of_their_source) {
  // 20 Gaussians in one place; 5 % more is one Gaussian. The source and its copy together cover as
  // much as before, 1 - (1 - o)^2, and are smaller.
  Case c(20, "mcmc");
  c.prepare_after(600, 1);
  ASSERT_EQ(c.model.size(), 21u);
  const Parameters& p = c.model.parameters;
  std::size_t source = 0;
  while (opacity(p, source) > 0.49) ++source;
  EXPECT_NEAR(1 - std::pow(1 - opacity(p, source), 2), 0.5, 1e-5);
  EXPECT_EQ(p.opacity_logits[20], p.opacity_logits[source]);
  EXPECT_EQ(p.means[20], p.means[source]);
  // Equation 9 for two: o^2 = (2 o' - o'^2 / sqrt 2)^2 s'^2 / s^2.
  const double o = opacity(p, source);
  EXPECT_NEAR(std::exp(p.log_scales[source].x), 0.02 * 0.5 / (2 * o - o * o / std::sqrt(2.0)),
              1e-6);
  EXPECT_EQ(c.model.adam.first.means[source], glm::vec3(0));
  EXPECT_EQ(c.model.adam.first.means[20], glm::vec3(0));
}

TEST(TrainMcmc, dead_gaussians_move_to_live_ones) {
  Case c(10, "mcmc");
  c.settings.max_gaussians = 10;
  c.model.parameters.opacity_logits[4] = -5.5f;
  const glm::vec3 before = c.model.parameters.means[4];
  c.prepare_after(700, 1);
  ASSERT_EQ(c.model.size(), 10u);
  EXPECT_NE(c.model.parameters.means[4], before);
  EXPECT_GT(opacity(c.model.parameters, 4), 0.2);
  int sources = 0;
  for (std::size_t i = 0; i < 10; ++i)
    sources += i != 4 && c.model.parameters.means[i] == c.model.parameters.means[4] ? 1 : 0;
  EXPECT_EQ(sources, 1);
}

TEST(TrainMcmc, noise_moves_nearly_transparent_gaussians_only) {
  Case c(2, "mcmc");
  c.model.parameters.opacity_logits[1] = -8;
  const Parameters before = c.model.parameters;
  const auto model = make_training_model(Backend::cpu, pool());
  model->set_state(c.model);
  model->step(find_strategy("mcmc").step({c.settings, 600, 1, rates_at(600, 1, 5e-2)}));
  EXPECT_EQ(model->state().parameters.means[0], before.means[0]);
  EXPECT_NE(model->state().parameters.means[1], before.means[1]);
}

TEST(TrainMcmc, does_the_same_in_a_larger_world) {
  const auto step_in_world_of = [](float size) {
    Case c(1, "mcmc");
    c.model.parameters.opacity_logits[0] = -8;
    c.model.parameters.means[0] = glm::vec3(0);
    c.model.parameters.log_scales[0] += std::log(size);
    const auto model = make_training_model(Backend::cpu, pool());
    model->set_state(c.model);
    const StepOrder order =
        find_strategy("mcmc").step({c.settings, 600, size, rates_at(600, size, 5e-2)});
    model->step(order);
    return std::pair{model->state().parameters.means[0] / size,
                     order.sparsity->scale_weight * size};
  };
  const auto [mean, weight] = step_in_world_of(1);
  const auto [mean_of_larger, weight_of_larger] = step_in_world_of(8);
  EXPECT_GT(glm::length(mean), 0);
  EXPECT_LT(glm::distance(mean_of_larger, mean), 1e-5 * glm::length(mean));
  EXPECT_NEAR(weight_of_larger, weight, 1e-9);
}

TEST(TrainStrategies, have_names_and_others_are_refused) {
  EXPECT_STREQ(find_strategy("adc").name, "adc");
  EXPECT_EQ(test::error_of([] { find_strategy("none"); }, ErrorKind::usage),
            "--strategy: 'none' is no strategy");
}

TEST(TrainMask, begins_with_masks_that_keep_every_gaussian) {
  const Parameters gaussians = with_masks(test::ball_of_gaussians(9, 1));
  EXPECT_TRUE(gaussians.has_masks);
  EXPECT_EQ(gaussians.mask_logits, std::vector<float>(9, 1.0f));
  EXPECT_EQ(find_strategy("mask").opacity_rate, 0.05);
}

TEST(TrainMask, removes_what_is_masked_out_at_changes_and_later_every_thousand_iterations) {
  for (const auto& [last, removes] : {std::pair{500, false},
                                      {600, true},
                                      {650, false},
                                      {14'900, true},
                                      {14'950, false},
                                      {15'000, true},
                                      {15'100, false},
                                      {16'000, true},
                                      {30'000, true}}) {
    Case c(4, "mask");
    c.model.parameters.mask_logits = {0, -4.6f, -4.59f, 3};
    c.prepare_after(last, 10);
    EXPECT_EQ(c.model.size(), removes ? 3 : 4) << last;
    if (!removes) continue;
    EXPECT_EQ(c.model.parameters.mask_logits, (std::vector<float>{0, -4.59f, 3})) << last;
    EXPECT_EQ(c.model.adam.first.mask_logits.size(), 3u) << last;
    EXPECT_EQ(c.model.adam.first.means[1], glm::vec3(7)) << last;
  }
}

TEST(TrainMask, resets_opacities_as_adc_and_keeps_masks) {
  Case c(3, "mask");
  c.model.parameters.mask_logits = {0, 2, 3};
  c.prepare_after(3000, 10);
  EXPECT_EQ(c.model.parameters.mask_logits, (std::vector<float>{0, 2, 3}));
  EXPECT_NEAR(opacity(c.model.parameters, 0), 0.01, 1e-6);
}

TEST(TrainMask, clones_and_children_of_splits_have_the_mask_of_their_gaussian) {
  for (const double extent : {10.0, 1.0}) {
    Case c(4, "mask");
    c.model.parameters.mask_logits = {0, 1, 2, 3};
    c.model.adam.second.mask_logits = {1, 1, 1, 1};
    c.set_gradient(2, 3e-4f);
    c.prepare_after(600, extent);
    const bool clones = extent == 10;
    EXPECT_EQ(c.model.parameters.mask_logits,
              clones ? (std::vector<float>{0, 1, 2, 3, 2}) : (std::vector<float>{0, 1, 3, 2, 2}));
    EXPECT_EQ(c.model.adam.second.mask_logits.back(), 0);
  }
}

TEST(TrainMask, steps_weigh_the_mean_mask_and_pause_where_gaussians_are_removed) {
  const TrainSettings settings;
  const auto step = [&](int iteration) {
    return find_strategy("mask").step({settings, iteration, 1, {}});
  };
  EXPECT_EQ(step(1).mask_weight, 5e-4);
  EXPECT_EQ(step(1).rates.mask, 0.01);
  EXPECT_TRUE(step(599).moves);
  EXPECT_FALSE(step(600).moves);
  EXPECT_FALSE(step(15'000).moves);
  EXPECT_TRUE(step(15'001).moves);
  EXPECT_FALSE(step(16'000).moves);
}

}  // namespace
}  // namespace qs::train
