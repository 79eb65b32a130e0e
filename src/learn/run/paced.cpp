// SPDX-License-Identifier: MIT
//
// Growth by the pace of a run: the number of Gaussians grows on a straight line from the start's to
// the target, and reaches it exactly at the end of growth. Everything follows the time of the run,
// which goes from 0 to 1: growth lasts from 0.05 to 0.7, with at most 60 changes, each after at
// least one pass over the training views. The rate of the means falls exponentially until the end,
// the other rates in the last part.
//
// The choices are from published trainers, one by one by experiment (docs/log/training.md): the
// line, the halved opacities and the cleared moments from LiteGS (its code), the split along the
// long axis from Improved-GS (arXiv 2508.12313), the draw without replacement from Taming 3DGS
// (arXiv 2406.15643), here by the absolute gradients of AbsGS.
#include <algorithm>
#include <cmath>
#include <utility>

#include "learn/gradient/activation.h"
#include "learn/run/density_rules.h"

namespace qs::train {
namespace {

constexpr double kGrowthBegin = 0.05, kGrowthEnd = kPacedGrowthEnd;
constexpr int kLeastChangeInterval = 100, kMostChanges = 60, kDecays = 9;
constexpr double kLastInterval = 0.75;  // at least, times the usual one
constexpr double kPixelsPerGaussian = 200;
constexpr std::size_t kIterationsPerView = 70, kLeastIterations = 3'000, kMostIterations = 30'000;
constexpr double kRounding = 1e-6;
constexpr double kFirstPacedMeanRate = 1.6e-4, kLastPacedMeanRate = 1.6e-5;  // times the extent
constexpr double kRatesFallFrom = 0.7, kFallenRates = 0.1;
constexpr double kLeastDecayed = 1.0 / 128, kPruned = 1.0 / 255;
// A child of a split, times the values of its parent; the offset in standard deviations.
constexpr double kSplitOffset = 1.35, kSplitScale = 0.55, kSplitOthers = 0.893, kSplitOpacity = 0.6;

/// The changes of the number of Gaussians. The last one is at the end of growth.
struct Growth {
  const RunFacts& run;

  /// Iterations between changes in a run of so many.
  double interval(int iterations) const {
    return std::max({static_cast<double>(kLeastChangeInterval), static_cast<double>(run.views),
                     (kGrowthEnd - kGrowthBegin) * iterations / kMostChanges});
  }
  /// The share of growth that is over after an iteration, 0..1.
  double share(int iteration) const {
    const double share = (run.pace.time(iteration) - kGrowthBegin) / (kGrowthEnd - kGrowthBegin);
    return std::clamp(share + kRounding, 0.0, 1.0);
  }
  /// The intervals between the beginning and an iteration.
  int intervals(int iteration) const {
    const int begin = run.pace.iteration_at(kGrowthBegin);
    double sum = 0;
    const auto& rows = run.pace.rows();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const int from = std::max(begin, rows[i].from);
      const int to = i + 1 < rows.size() ? std::min(iteration, rows[i + 1].from) : iteration;
      sum += std::max(0, to - from) / interval(rows[i].iterations);
    }
    return static_cast<int>(sum + kRounding);
  }
  bool changes_after(int iteration) const {
    const double time = run.pace.time(iteration);
    if (share(iteration) == 1) return share(iteration - 1) < 1;
    if (intervals(iteration) == intervals(iteration - 1)) return false;
    const int iterations = run.pace.iterations_in(iteration);
    return (kGrowthEnd - time) * iterations > kLastInterval * interval(iterations);
  }
  /// True if opacities are halved at the change after this iteration: at 9 equal steps of growth.
  bool halves_after(int iteration) const {
    int last = iteration - 1;
    while (last > 0 && !changes_after(last)) --last;
    const auto steps = [&](int at) { return static_cast<int>(kDecays * share(at) + kRounding); };
    return steps(iteration) > steps(last);
  }
};

void set_opacity(Plan& plan, std::size_t i, double value) {
  plan.opacity_logits[i] = static_cast<float>(logit_of(value));
}

// Halves all opacities, and begins again with moments of 0: a step of Adam is then several times as
// large for about 500 iterations.
void halve_opacities(Plan& plan) {
  for (std::size_t i = 0; i < plan.size(); ++i)
    set_opacity(plan, i, std::max(opacity(plan, i) / 2, kLeastDecayed));
  std::ranges::fill(plan.moment_sources, Plan::kZeros);
}

// The weighted draw of `count` of weights.size() numbers, each of them once: the smallest
// -log(u) / weight win (Efraimidis and Spirakis 2006), ties by index. Further rounds follow if
// there are too few.
std::vector<std::uint32_t> drawn_once(const std::vector<double>& weights, std::size_t count,
                                      const Random& random) {
  std::vector<std::uint32_t> result;
  for (std::uint64_t round = 0; result.size() < count; ++round) {
    std::vector<std::pair<double, std::uint32_t>> keys;
    for (std::uint32_t i = 0; i < weights.size(); ++i)
      if (weights[i] > 0)
        keys.emplace_back(-std::log(1 - random.uniform(round * weights.size() + i)) / weights[i],
                          i);
    const std::size_t taken = std::min(count - result.size(), keys.size());
    std::nth_element(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(taken), keys.end());
    keys.resize(taken);
    std::ranges::sort(keys, {}, &std::pair<double, std::uint32_t>::second);
    for (const auto& [key, i] : keys) result.push_back(i);
  }
  return result;
}

// The mean absolute gradients; equal weights if all are 0.
std::vector<double> weights_of(const GaussianFacts& facts, const Plan& plan) {
  std::vector<double> weights;
  for (const std::uint32_t from : plan.sources)
    weights.push_back(facts.density.mean_absolute(from));
  if (std::ranges::none_of(weights, [](double weight) { return weight > 0; }))
    std::ranges::fill(weights, 1.0);
  return weights;
}

// Two children on the long axis replace the Gaussian.
void split_long(Plan& plan, std::size_t i, const glm::quat& rotation) {
  const glm::dmat3 axes = glm::mat3_cast(unit_rotation(glm::dquat(rotation)));
  const glm::vec3 s = plan.log_scales[i];
  const int axis = s.x >= s.y && s.x >= s.z ? 0 : s.y >= s.z ? 1 : 2;
  const glm::vec3 offset(axes[axis] * (kSplitOffset * std::exp(static_cast<double>(s[axis]))));
  for (int k = 0; k < 3; ++k)
    plan.log_scales[i][k] += static_cast<float>(std::log(k == axis ? kSplitScale : kSplitOthers));
  set_opacity(plan, i, kSplitOpacity * opacity(plan, i));
  plan.moment_sources[i] = Plan::kZeros;
  plan.add_copy_of(i);
  plan.means[i] += offset;
  plan.means.back() -= offset;
}

}  // namespace

std::size_t paced_target(const TrainSettings& settings, const RunFacts& run) {
  if (settings.max_gaussians > 0) return settings.max_gaussians;
  return static_cast<std::size_t>(static_cast<double>(run.pixels) / kPixelsPerGaussian);
}

int paced_iterations(std::size_t views) {
  return static_cast<int>(
      std::clamp(kIterationsPerView * views, kLeastIterations, kMostIterations));
}

bool paced_changes_after(const RunFacts& run, int iteration) {
  if (run.stopped_after > 0) return iteration == run.stopped_after;
  return Growth{run}.changes_after(iteration);
}

void paced_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  if (context.run.stopped_after > 0) {
    halve_opacities(plan);
    return;
  }
  const Growth growth{context.run};
  const int over = context.iteration - 1;
  if (plan.growth.initial == 0)
    plan.growth = {facts.size(), paced_target(context.settings, context.run)};
  remove_faint(kPruned, plan);
  const auto [initial, target] = plan.growth;
  if (target > initial && plan.size() > 0) {
    const double added = static_cast<double>(target - initial) * growth.share(over);
    const std::size_t wanted = initial + static_cast<std::size_t>(added + kRounding);
    if (wanted > plan.size())
      for (const std::uint32_t i : drawn_once(weights_of(facts, plan), wanted - plan.size(),
                                              context.random(RandomUse::add)))
        split_long(plan, i, facts.rotations[plan.sources[i]]);
  }
  if (growth.halves_after(over)) halve_opacities(plan);
}

void paced_step(const IterationContext& context, StepOrder& order) {
  const double t = context.run.pace.time(context.iteration);
  const int stopped = context.run.stopped_after;
  double falls_from = kRatesFallFrom;
  if (stopped > 0) falls_from = std::min(falls_from, context.run.pace.time(stopped));
  const double fallen = (t - falls_from) / (1 - falls_from);
  const double factor = fallen > 0 ? std::pow(kFallenRates, fallen) : 1;
  Rates& rates = order.rates;
  for (double* rate :
       {&rates.log_scale, &rates.rotation, &rates.opacity, &rates.sh_dc, &rates.sh_rest})
    *rate *= factor;
  rates.mean =
      kFirstPacedMeanRate * std::pow(kLastPacedMeanRate / kFirstPacedMeanRate, t) * context.extent;
  order.counts_density = stopped == 0 && t <= kGrowthEnd;
}

}  // namespace qs::train
