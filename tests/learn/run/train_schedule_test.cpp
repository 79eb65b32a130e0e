// SPDX-License-Identifier: MIT
// The start of training, the values that depend on the iteration, and the log.
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/support/training.h"
#include "learn/run/initial.h"
#include "learn/run/schedule.h"
#include "learn/run/train_log.h"
#include "learn/step/nearest.h"
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

TEST(TrainSchedule, drawn_views_differ_from_each_other_and_end_where_views_do) {
  for (const std::size_t views : {0u, 1u, 9u, 10u, 300u}) {
    const auto drawn = drawn_views(views, 10, 5, 1001);
    EXPECT_EQ(drawn.size(), std::min<std::size_t>(views, 10));
    EXPECT_EQ(std::set<std::size_t>(drawn.begin(), drawn.end()).size(), drawn.size());
    for (const std::size_t view : drawn) EXPECT_LT(view, views);
    EXPECT_EQ(drawn_views(views, 10, 5, 1001), drawn);
  }
  EXPECT_NE(drawn_views(300, 10, 5, 1001), drawn_views(300, 10, 5, 1501));
  EXPECT_NE(drawn_views(300, 10, 5, 1001), drawn_views(300, 10, 6, 1001));
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
    EXPECT_EQ(means[i], all[0] / 3 + all[1] / 3 + all[2] / 3);
  }
}

TEST(TrainStart, many_copies_of_a_point_are_searched_in_little_time) {
  // It would take a minute if every search went through all copies.
  const std::vector<glm::vec3> points(100'000, {0.1f, 2, 3});
  const std::vector<double> means = neighbour_distances2(points, pool());
  EXPECT_EQ(means, std::vector<double>(points.size(), 0));
}

TEST(TrainStart, few_points_use_the_neighbours_that_exist) {
  EXPECT_TRUE(neighbour_distances2({}, pool()).empty());
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

TEST(TrainStart, random_points_fill_what_many_pictures_show) {
  const DataSet data = test::data_set_of(test::ball_of_gaussians(3, 1), 40);
  const auto points = random_points(data, 5000, 1);
  glm::dvec3 low(1e9), high(-1e9), mean(0), least(1e9), most(-1e9);
  double nearest_camera = 1e9;
  for (const PhotographView& view : data.training) {
    low = glm::min(low, view.camera.position());
    high = glm::max(high, view.camera.position());
  }
  const glm::dvec3 middle = 0.5 * (low + high), size = high - low;
  for (const ScenePoint& point : points) {
    mean += point.position / 5000.0;
    least = glm::min(least, point.position);
    most = glm::max(most, point.position);
    for (int k = 0; k < 3; ++k)
      EXPECT_LE(std::abs(point.position[k] - middle[k]),
                std::max(1.5 * size[k], data.extent()) + 1e-9);
    for (const PhotographView& view : data.training)
      nearest_camera =
          std::min(nearest_camera, glm::distance(view.camera.position(), point.position));
  }
  // The cameras circle a ball of radius about 1 at the origin.
  EXPECT_LT(glm::length(mean), 0.2);
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT(least[k], -0.5);
    EXPECT_GT(most[k], 0.5);
  }
  EXPECT_GT(nearest_camera, 0.2 * data.extent());

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
  log.evaluation_seconds = 1.5;
  EXPECT_EQ(most_gpu_memory(log), std::nullopt);
  EXPECT_EQ(most_gpu_memory(log_of(log_json(log))), std::nullopt);
  log.rows[1].gpu_memory_bytes = 5'000'000'000;
  log.rows[2].gpu_memory_bytes = 4'000'000'000;
  const TrainLog read = log_of(log_json(log));
  EXPECT_EQ(format_train_csv(read), format_train_csv(log));
  EXPECT_EQ(most_gpu_memory(read), 5'000'000'000);
  EXPECT_EQ(read.rows[2].gpu_memory_bytes, 4'000'000'000);
  EXPECT_EQ(read.rows[3].loss, 1.0 / 3);
  EXPECT_EQ(read.loss_sum, 0.1);
  EXPECT_EQ(read.loss_count, 3);
  EXPECT_EQ(read.stage_seconds, log.stage_seconds);
  EXPECT_EQ(read.evaluation_seconds, 1.5);
  EXPECT_EQ(format_train_csv(log),
            "iteration,seconds,loss,gaussians,test_psnr,test_ssim\n"
            "100,1.000,0.500000,10,,\n200,2.000,0.400000,20,25.0000,0.80000\n"
            "300,3.000,0.300000,30,26.0000,0.90000\n400,4.250,0.333333,30,25.5000,0.91000\n");
}

}  // namespace
}  // namespace qs::train
