// SPDX-License-Identifier: MIT
// Schedules, starting Gaussians and strategies of training, against their published rules.
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/train/initial.h"
#include "app/train/nearest.h"
#include "app/train/schedule.h"
#include "app/train/strategy.h"
#include "app/train/train_log.h"
#include "app/training.h"
#include "raster/kernel/activation.h"
#include "support/error_of.h"
#include "support/pool.h"

namespace qs::train {
namespace {

using test::pool;

TEST(TrainSchedule, rate_of_the_means_falls_a_hundredfold_in_30000_iterations) {
  EXPECT_NEAR(rates_at(0, 2, 0.05).mean, 2 * 1.6e-4, 1e-12);
  EXPECT_NEAR(rates_at(15'000, 2, 0.05).mean, 2 * 1.6e-5, 1e-12);
  EXPECT_NEAR(rates_at(30'000, 2, 0.05).mean, 2 * 1.6e-6, 1e-14);
  EXPECT_EQ(rates_at(50'000, 2, 0.05).mean, rates_at(30'000, 2, 0.05).mean);
  EXPECT_EQ(rates_at(7, 2, 0.05).opacity, 0.05);
}

TEST(TrainSchedule, sh_degree_grows_every_1000_iterations) {
  EXPECT_EQ(sh_degree_at(999, 3), 0);
  EXPECT_EQ(sh_degree_at(1000, 3), 1);
  EXPECT_EQ(sh_degree_at(3500, 3), 3);
  EXPECT_EQ(sh_degree_at(29'999, 3), 3);
  EXPECT_EQ(sh_degree_at(29'999, 1), 1);
}

TEST(TrainSchedule, every_round_shows_each_view_once_in_another_order) {
  ViewOrder order(10, 5);
  std::vector<std::vector<std::size_t>> rounds;
  for (int round = 0; round < 3; ++round) {
    rounds.emplace_back();
    for (int i = 1; i <= 10; ++i) rounds.back().push_back(order.at(10 * round + i));
    EXPECT_EQ(std::set<std::size_t>(rounds.back().begin(), rounds.back().end()).size(), 10u);
  }
  EXPECT_NE(rounds[0], rounds[1]);
  EXPECT_NE(rounds[1], rounds[2]);
  EXPECT_EQ(ViewOrder(10, 5).at(17), rounds[1][6]) << "it does not depend on earlier calls";
  ViewOrder other(10, 6);
  std::vector<std::size_t> first;
  for (int i = 1; i <= 10; ++i) first.push_back(other.at(i));
  EXPECT_NE(first, rounds[0]) << "another seed";
}

TEST(TrainStart, neighbour_distances_equal_a_search_of_all_pairs) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  std::vector<glm::vec3> points;
  for (int i = 0; i < 700; ++i)
    points.emplace_back(normal(random), 0.1f * normal(random), std::round(4 * normal(random)));
  points.push_back(points[5]);  // a point twice
  const std::vector<double> means = neighbour_distances2(points, pool());
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::vector<double> all;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const glm::dvec3 d = glm::dvec3(points[k]) - glm::dvec3(points[i]);
      if (k != i) all.push_back(glm::dot(d, d));
    }
    std::sort(all.begin(), all.end());
    EXPECT_NEAR(means[i], (all[0] + all[1] + all[2]) / 3, 1e-12);
  }
}

TEST(TrainStart, few_points_use_the_neighbours_that_exist) {
  EXPECT_EQ(neighbour_distances2({{1, 2, 3}}, pool()), std::vector<double>{0});
  EXPECT_EQ(neighbour_distances2({{0, 0, 0}, {0, 3, 4}}, pool()), (std::vector<double>{25, 25}));
}

TEST(TrainStart, gaussians_have_the_colour_of_their_point_and_the_size_of_its_surroundings) {
  const std::vector<ScenePoint> points = {{{0, 0, 0}, {0.5f, 1, 0}}, {{0, 0, 2}, {0, 0, 0}}};
  const Parameters start = gaussians_at(points, {3, 0.1, 1}, pool());
  ASSERT_EQ(start.size(), 2u);
  EXPECT_EQ(start.means[1], glm::vec3(0, 0, 2));
  EXPECT_FLOAT_EQ(start.log_scales[0].y, std::log(2.0f));
  EXPECT_NEAR(opacity(start, 0), 0.1, 1e-7);
  EXPECT_NEAR(0.5 + 0.28209479177387814 * start.sh[0].y, 1, 1e-6);
  EXPECT_EQ(start.sh[1], glm::vec3(0));
  EXPECT_FLOAT_EQ(gaussians_at({{{1, 1, 1}, {0, 0, 0}}}, {0, 0.5, 0.1}, pool()).log_scales[0].x,
                  static_cast<float>(std::log(0.1 * std::sqrt(1e-7))))
      << "a single point has the least size";
}

TEST(TrainStart, random_points_fill_the_enlarged_box_of_the_cameras) {
  const DataSet data = test::data_set_of(test::ball_of_gaussians(3, 1), 8);
  const auto points = random_points(data, 5000, 1);
  glm::dvec3 low(1e9), high(-1e9), mean(0);
  for (const PhotographView& view : data.training) {
    low = glm::min(low, view.camera.position());
    high = glm::max(high, view.camera.position());
  }
  const glm::dvec3 middle = 0.5 * (low + high), size = high - low;
  for (const ScenePoint& point : points) {
    mean += point.position / 5000.0;
    for (int k = 0; k < 3; ++k)
      EXPECT_LE(std::abs(point.position[k] - middle[k]),
                std::max(1.5 * size[k], data.extent()) + 1e-9);
  }
  EXPECT_LT(glm::distance(mean, middle), 0.3);

  DataSet blender = data;
  blender.blender = true;
  double largest = 0;
  for (const ScenePoint& point : random_points(blender, 5000, 1)) {
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(point.position[k]));
  }
  EXPECT_LE(largest, 1.3);
  EXPECT_GT(largest, 1.29);
}

TEST(TrainLog, finds_the_best_evaluation_and_survives_json) {
  TrainLog log;
  EXPECT_EQ(best_row(log), nullptr);
  log.rows = {{100, 1, 0.5, 10, {}},
              {200, 2, 0.4, 20, Quality{25, 0.8}},
              {300, 3, 0.3, 30, Quality{26, 0.9}},
              {400, 4.25, 1.0 / 3, 30, Quality{25.5, 0.91}}};
  EXPECT_EQ(best_row(log)->iteration, 300);
  log.loss_sum = 0.1;
  log.loss_count = 3;
  log.stage_seconds[2] = 7.25;
  const TrainLog read = log_of(log_json(log));
  EXPECT_EQ(format_train_csv(read), format_train_csv(log));
  EXPECT_EQ(read.rows[3].loss, 1.0 / 3);
  EXPECT_EQ(read.loss_sum, 0.1);
  EXPECT_EQ(read.loss_count, 3);
  EXPECT_EQ(read.stage_seconds, log.stage_seconds);
  EXPECT_EQ(format_train_csv(log),
            "iteration,seconds,loss,gaussians,test_psnr,test_ssim\n"
            "100,1.000,0.500000,10,,\n200,2.000,0.400000,20,25.0000,0.80000\n"
            "300,3.000,0.300000,30,26.0000,0.90000\n400,4.250,0.333333,30,25.5000,0.91000\n");
}

// ---- strategies
// ----------------------------------------------------------------------------------

/// A model whose iteration `last` is over, and what prepare() then does with it.
struct Case {
  TrainSettings settings;
  ModelState model;
  cpu::train::Rates rates = rates_at(1, 1, 2.5e-2);

  explicit Case(std::size_t gaussians, const char* strategy = "adc") {
    settings.sh_degree = 0;
    settings.strategy = strategy;
    Parameters parameters = test::ball_of_gaussians(gaussians, 1);
    for (float& logit : parameters.opacity_logits) logit = 0;
    for (glm::vec3& log_scale : parameters.log_scales)
      log_scale = glm::vec3(std::log(0.02f), std::log(0.005f), std::log(0.005f));
    model = ModelState::starting_with(std::move(parameters));
    for (auto* moments : {&model.adam.first, &model.adam.second}) {
      for (glm::vec3& value : moments->means) value = glm::vec3(7);
      for (float& value : moments->opacity_logits) value = 7;
    }
  }
  void prepare_after(int last, double extent) {
    const ModelContext context{settings, last + 1, extent, rates, pool(), model};
    find_strategy(settings.strategy).prepare(context);
  }
  /// Gaussian i has this mean gradient on the image.
  void set_gradient(std::size_t i, float gradient) {
    model.density.sums[i] = 3 * gradient;
    model.density.views[i] = 3;
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

TEST(TrainMcmc, copies_share_the_opacity_of_their_source) {
  // 20 Gaussians in one place, of which 5 % more is one: the source and its copy together cover as
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
  Gradients gradients;
  gradients.reset(c.model.parameters);
  find_strategy("mcmc").step({{c.settings, 600, 1, c.rates, pool(), c.model}, 64, 48, gradients});
  EXPECT_EQ(c.model.parameters.means[0], before.means[0]);
  EXPECT_NE(c.model.parameters.means[1], before.means[1]);
}

TEST(TrainStrategies, have_names_and_others_are_refused) {
  EXPECT_STREQ(find_strategy("adc").name, "adc");
  EXPECT_EQ(test::error_of([] { find_strategy("none"); }, ErrorKind::usage),
            "--strategy: 'none' is no strategy");
}

}  // namespace
}  // namespace qs::train
