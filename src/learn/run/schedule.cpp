// SPDX-License-Identifier: MIT
#include "learn/run/schedule.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "raster/kernel/random.h"

namespace qs::train {
namespace {

constexpr double kFirstMeanRate = 1.6e-4, kLastMeanRate = 1.6e-6;
constexpr int kMeanRateIterations = 30'000;
constexpr int kShDegreeIterations = 1000;

}  // namespace

Rates rates_at(int iteration, double extent, double opacity_rate, MeanRateStart start) {
  const int falls_for = std::max(1, kMeanRateIterations - start.falls_from);
  const double t =
      std::clamp(static_cast<double>(iteration - start.falls_from) / falls_for, 0.0, 1.0);
  const bool moves = start.moves_before || iteration >= start.falls_from;
  const double mean =
      moves ? std::exp((1 - t) * std::log(kFirstMeanRate) + t * std::log(kLastMeanRate)) : 0;
  return {.mean = mean * extent,
          .log_scale = 5e-3,
          .rotation = 1e-3,
          .opacity = opacity_rate,
          .sh_dc = 2.5e-3,
          .sh_rest = 2.5e-3 / 20};
}

int sh_degree_at(int iteration, int most) {
  return std::min(most, iteration / kShDegreeIterations);
}

std::size_t ViewOrder::at(int iteration) {
  const auto number = static_cast<std::uint64_t>(iteration - 1);
  const std::uint64_t round = number / views_;
  if (round != round_) {
    round_ = round;
    order_.resize(views_);
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    const Random random = Random::of(seed_, RandomUse::views, round);
    for (std::size_t left = views_; left > 1; --left)
      std::swap(order_[left - 1], order_[random.bits(left) % left]);
  }
  return order_[number % views_];
}

std::vector<std::size_t> drawn_views(std::size_t views, std::size_t count, std::uint64_t seed,
                                     int iteration) {
  std::vector<std::size_t> order(views);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const Random random =
      Random::of(seed, RandomUse::scored_views, static_cast<std::uint64_t>(iteration));
  count = std::min(count, views);
  for (std::size_t drawn = 0; drawn < count; ++drawn)
    std::swap(order[drawn], order[drawn + random.bits(drawn) % (views - drawn)]);
  order.resize(count);
  return order;
}

}  // namespace qs::train
