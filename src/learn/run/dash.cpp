// SPDX-License-Identifier: MIT
//
// DashGaussian (Chen et al., CVPR 2025, and its published code): photographs are reduced at first
// (schedule.h), and the number of Gaussians grows with the resolution. The number is
// limited by a budget, which grows with the number of Gaussians that want to be cloned or split.
// Gaussians are added in nine tenths of the run, published as 27,000 of 30,000 iterations; shorter
// runs have a shorter schedule.
#include <algorithm>
#include <cmath>

#include "learn/run/density_rules.h"

namespace qs::train {
namespace {

constexpr int kDashInterval = 100;  // as Strategy::interval
constexpr float kDashGradient = 2e-4f;
constexpr double kDashSmall = 0.01;  // times the extent: smaller ones are cloned, others split
constexpr double kMostGrowth = 0.2;  // a change adds at most this share of all Gaussians
constexpr std::uint64_t kFirstBudget = 5;  // times the initial number
constexpr double kBudgetDecay = 0.98;
constexpr std::uint64_t kMostBudgetGrowth = 1'000'000;

// The number of Gaussians to have after the change behind `iteration`, whose photographs were
// reduced by `factor`.
std::uint64_t wanted_number(const TrainSettings& settings, const GrowthState& growth, int iteration,
                            int factor) {
  const int end = settings.reduced_until();
  if (iteration + kDashInterval >= end) return growth.initial + growth.budget;
  const double share = std::pow(factor, 2 - static_cast<double>(iteration) / end);
  return growth.initial + static_cast<std::uint64_t>(static_cast<double>(growth.budget) / share);
}

// The number of Gaussians to add, if as many want to be cloned or split.
std::size_t most_additions(const IterationContext& context, const GaussianFacts& facts,
                           const GrowthState& growth, std::size_t kept) {
  const auto number = static_cast<double>(facts.size());
  const auto wanted = static_cast<double>(
      wanted_number(context.settings, growth, context.iteration - 1, context.last_factor));
  const double rate = std::clamp((wanted - number) / number, 0.0, kMostGrowth);
  const auto most = static_cast<std::size_t>(number * (1 + rate));
  return most > kept ? std::min(most - kept, kept) : 0;
}

}  // namespace

void dash_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  GrowthState& growth = plan.growth;
  if (growth.initial == 0) growth = {facts.size(), kFirstBudget * facts.size()};
  std::size_t kept = 0;
  std::vector<Candidate> candidates;
  for (std::uint32_t i = 0; i < facts.size(); ++i) {
    if (opacity(facts, i) < kLeastOpacity) continue;
    ++kept;
    const float gradient = facts.density.mean(i);
    if (gradient >= kDashGradient)
      candidates.push_back({i, gradient, largest_scale(facts, i) > kDashSmall * context.extent});
  }
  const std::size_t above = candidates.size();
  keep_most_urgent(most_additions(context, facts, growth, kept), candidates);
  clone_and_split(context, facts, std::move(candidates), plan);
  remove_faint(kLeastOpacity, plan);
  const auto grown = static_cast<std::uint64_t>(
      kBudgetDecay * static_cast<double>(growth.budget) +
      static_cast<double>(std::min<std::uint64_t>(above, kMostBudgetGrowth)));
  growth.budget = std::max(growth.budget, grown);
}

}  // namespace qs::train
