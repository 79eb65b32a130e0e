// SPDX-License-Identifier: MIT
//
// A budget of Gaussians: their number grows on a straight line from the start's to the target, and
// reaches it exactly at the end of growth. Everything follows the number N of iterations: growth
// lasts from 0.05 N to 0.7 N, with at most 60 changes, each after at least one pass over the
// training views. The rate of the means falls exponentially until N, the other rates in the last
// part. As in 3DGS-MCMC, nearly transparent Gaussians move, noise moves means, and opacities and
// scales have weights in the loss.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "learn/gradient/activation.h"
#include "learn/run/budget_keys.h"
#include "learn/run/density_rules.h"
#include "learn/run/schedule.h"

namespace qs::train {
namespace {

constexpr double kGrowthBegin = 0.05, kGrowthEnd = kBudgetGrowthEnd;  // times of the run
constexpr int kLeastInterval = 100, kMostChanges = 60, kDecays = 9;
constexpr double kLastInterval = 0.75;  // at least, times the usual one
constexpr double kRounding = 1e-6;
constexpr double kFirstRate = 1.6e-4;  // of the means, times the extent
constexpr double kFallenRates = 0.1;
constexpr double kBesideScale = 0.01;  // times the extent: smaller ones are copied
constexpr double kLeastDecayed = 1.0 / 128, kPruned = 1.0 / 255;
constexpr double kLongOffset = 1.35, kLongScale = 0.55, kLongOthers = 0.893, kLongOpacity = 0.6;
constexpr double kRecovered = 0.2;

/// The changes of the number of Gaussians. The last one is at the end of growth.
struct Growth {
  const RunFacts& run;

  /// Iterations between changes in a run of so many.
  double interval(int iterations) const {
    return std::max({static_cast<double>(kLeastInterval), static_cast<double>(run.views),
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
  int change_before(int iteration) const {
    while (--iteration > 0 && !changes_after(iteration)) continue;
    return iteration;
  }
  /// The decays of opacities until after an iteration, of 9 equal steps.
  int decays(int iteration) const {
    return static_cast<int>(kDecays * share(iteration) + kRounding);
  }
};

template <class NewOpacity>
void change_opacities(Plan& plan, const NewOpacity& changed_opacity) {
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const double next = std::clamp(changed_opacity(opacity(plan, i)), 1e-6, 1 - 1e-6);
    plan.opacity_logits[i] = static_cast<float>(std::log(next / (1 - next)));
  }
}

void halve_opacities(Plan& plan) {
  change_opacities(plan, [](double o) { return std::max(o / 2, kLeastDecayed); });
}

void clear_moments(Plan& plan) {
  if (budget_keys().clear == "all") std::ranges::fill(plan.moment_sources, Plan::kZeros);
  if (budget_keys().clear == "opacity") plan.clears_opacity_moments = true;
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

std::vector<double> weights_of(const GaussianFacts& facts, const Plan& plan) {
  const std::string& score = budget_keys().score;
  std::vector<double> weights(plan.size());
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const std::uint32_t from = plan.sources[i];
    const double gradient = facts.density.mean_absolute(from);
    if (score == "opacity") weights[i] = opacity(plan, i);
    if (score == "gradient") weights[i] = gradient;
    if (score == "share") weights[i] = gradient * facts.counts.flagged_share(from);
    if (score == "flagged" && !facts.counts.flagged.empty())
      weights[i] = opacity(plan, i) * facts.counts.flagged[from];
  }
  if (std::ranges::none_of(weights, [](double weight) { return weight > 0; }))
    std::ranges::fill(weights, 1.0);
  return weights;
}

// Two children at +-1.35 standard deviations of the long axis replace the Gaussian.
void split_long(Plan& plan, std::size_t i, const glm::quat& rotation) {
  const glm::dmat3 axes = glm::mat3_cast(unit_rotation(glm::dquat(rotation)));
  const glm::vec3 s = plan.log_scales[i];
  const int axis = s.x >= s.y && s.x >= s.z ? 0 : s.y >= s.z ? 1 : 2;
  const glm::vec3 offset(axes[axis] * (kLongOffset * std::exp(static_cast<double>(s[axis]))));
  for (int k = 0; k < 3; ++k)
    plan.log_scales[i][k] += static_cast<float>(std::log(k == axis ? kLongScale : kLongOthers));
  const double kept = kLongOpacity * opacity(plan, i);
  plan.opacity_logits[i] = static_cast<float>(std::log(kept / (1 - kept)));
  plan.moment_sources[i] = Plan::kZeros;
  plan.add_copy_of(i);
  plan.means[i] += offset;
  plan.means.back() -= offset;
}

void add(const IterationContext& context, const GaussianFacts& facts, std::size_t count,
         Plan& plan) {
  const BudgetKeys& keys = budget_keys();
  const auto sources =
      keys.score == "opacity" && keys.replace != 0
          ? sources_of_growth(context, plan, count)
          : drawn_once(weights_of(facts, plan), count, context.random(RandomUse::add));
  if (keys.child == "relocate") return add_sharing(sources, plan);
  const Random random = context.random(RandomUse::split);
  for (std::size_t n = 0; n < sources.size(); ++n) {
    const std::uint32_t i = sources[n];
    const glm::quat& rotation = facts.rotations[plan.sources[i]];
    if (keys.child == "long") {
      split_long(plan, i, rotation);
      continue;
    }
    const bool large = largest_scale(plan, i) > kBesideScale * context.extent;
    plan.add_copy_of(i);
    if (large) shrink_child(plan, plan.size() - 1, rotation, random.normal3(n));
  }
}

void prune_unneeded(const GaussianFacts& facts, Plan& plan) {
  if (budget_keys().prune == "unseen" && !facts.counts.blended.empty())
    plan.keep_if([&](std::size_t i) { return facts.counts.blended[plan.sources[i]] > 0; });
  else
    remove_faint(kPruned, plan);
}

// Removes the lowest fifth by opacity, ties by index.
void remove_lowest(Plan& plan) {
  std::vector<std::uint32_t> order(plan.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return plan.opacity_logits[i]; });
  std::vector<bool> goes(plan.size());
  const auto removed = static_cast<std::size_t>(kRecovered * static_cast<double>(plan.size()));
  for (std::size_t n = 0; n < removed; ++n) goes[order[n]] = true;
  plan.keep_if([&](std::size_t i) { return !goes[i]; });
}

void decay(const IterationContext& context, const Growth& growth, Plan& plan) {
  const BudgetKeys& keys = budget_keys();
  const double t = context.run.pace.time(context.iteration - 1);
  const int last = growth.change_before(context.iteration - 1);
  const bool is_step = growth.decays(context.iteration - 1) > growth.decays(last);
  const double before = context.run.pace.time(last), step = t - before;
  const bool is_reset = std::floor(10 * t) > std::floor(10 * before) && t < 0.5;
  if (keys.decay == "none" || (keys.decay == "half" && !is_step) ||
      (keys.decay == "reset" && !is_reset))
    return;
  if (keys.decay == "half") halve_opacities(plan);
  if (keys.decay == "mild") change_opacities(plan, [&](double o) { return o * keys.amount; });
  if (keys.decay == "minus")
    change_opacities(plan, [&](double o) {
      return o - keys.amount * (1 - t) * step * context.settings.iterations / 200;
    });
  if (keys.decay == "clamp") limit_opacities(0.8, plan);
  if (keys.decay == "reset") limit_opacities(kResetOpacity, plan);
  clear_moments(plan);
}

// base=few: strategy fastgs, with its 30,000 iterations scaled to the run.

int published_iteration(const TrainSettings& settings, int iteration) {
  return static_cast<int>(30'000L * iteration / settings.iterations);
}

// The published iteration, a multiple of `step`, that this one stands for; 0: none.
int published_multiple(const TrainSettings& settings, int iteration, int step) {
  const int now = published_iteration(settings, iteration) / step;
  return now > published_iteration(settings, iteration - 1) / step ? now * step : 0;
}

struct FewEvents {
  int change, reset, final_prune;

  static FewEvents after(const TrainSettings& settings, int iteration) {
    const int change = published_multiple(settings, iteration, 500);
    const int later = published_multiple(settings, iteration, 3000);
    return {change >= 1000 && change < kDensityEnd ? change : 0, later < kDensityEnd ? later : 0,
            final_prune_after(later, kDensityEnd) ? later : 0};
  }
};

void few_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  const FewEvents events = FewEvents::after(context.settings, context.iteration - 1);
  IterationContext published = context;
  published.iteration = events.change + 1;
  if (events.change > 0) fastgs_change(published, facts, plan);
  if (events.reset > 0) limit_opacities(kResetOpacity, plan);
  if (events.final_prune > 0) remove_faint(kFinalOpacity, plan);
}

}  // namespace

std::size_t budget_target(const TrainSettings& settings, const RunFacts& run) {
  if (settings.max_gaussians > 0) return settings.max_gaussians;
  return static_cast<std::size_t>(static_cast<double>(run.pixels) / budget_keys().divisor);
}

bool budget_changes_after(const TrainSettings& settings, const RunFacts& run, int iteration) {
  if (run.stopped_after > 0) return iteration == run.stopped_after;
  if (budget_keys().base == "few") {
    const FewEvents events = FewEvents::after(settings, iteration);
    return events.change + events.reset + events.final_prune > 0;
  }
  return Growth{run}.changes_after(iteration);
}

void budget_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  if (context.run.stopped_after > 0) {
    halve_opacities(plan);
    return clear_moments(plan);
  }
  const BudgetKeys& keys = budget_keys();
  if (keys.base == "few") return few_change(context, facts, plan);
  const Growth growth{context.run};
  const int over = context.iteration - 1, last = growth.change_before(over);
  if (plan.growth.initial == 0)
    plan.growth = {facts.size(), budget_target(context.settings, context.run)};
  const int decays = growth.decays(last);
  if (keys.recover != 0 && decays > growth.decays(growth.change_before(last)) &&
      (decays == 3 || decays == 6))
    remove_lowest(plan);
  if (keys.base == "mcmc")
    relocate_dead(context, plan);
  else
    prune_unneeded(facts, plan);
  const auto [initial, target] = plan.growth;
  if (target > initial) {
    const double added = static_cast<double>(target - initial) * growth.share(over);
    const std::size_t wanted = initial + static_cast<std::size_t>(added + kRounding);
    if (wanted > plan.size() && plan.size() > 0) add(context, facts, wanted - plan.size(), plan);
  }
  decay(context, growth, plan);
}

void budget_step(const IterationContext& context, StepOrder& order) {
  const BudgetKeys& keys = budget_keys();
  const Pace& pace = context.run.pace;
  const double t = pace.time(context.iteration);
  const int stopped = context.run.stopped_after;
  IterationContext here = context;
  Rates& rates = here.rates;
  double falls_from = 1 - keys.fall;
  if (stopped > 0) falls_from = std::min(falls_from, pace.time(stopped));
  const double fallen = (t - falls_from) / (1 - falls_from);
  const double factor = fallen > 0 ? std::pow(kFallenRates, fallen) : 1;
  rates.sh_rest = keys.rest;
  for (double* rate :
       {&rates.log_scale, &rates.rotation, &rates.opacity, &rates.sh_dc, &rates.sh_rest})
    *rate *= factor;
  rates.mean = kFirstRate * std::pow(keys.mean_end / kFirstRate, t) * context.extent;
  order.rates = rates;
  order.counts_density =
      (keys.score == "gradient" || keys.score == "share") && stopped == 0 && t <= kGrowthEnd;
  if (keys.base == "few") {
    const int published = published_iteration(context.settings, context.iteration);
    rates = order.rates = rates_at(published, context.extent, context.rates.opacity);
    order.counts_density = published < kDensityEnd;
  }
  mcmc_step(here, order);
  const int sums = t > kGrowthEnd ? static_cast<int>(keys.sums) : 0;
  if (sums > 1) {
    order.sums = true;
    order.moves = order.moves && context.iteration % sums == 0;
    order.sparsity->opacity_weight *= sums;
    order.sparsity->scale_weight *= sums;
  }
  if (keys.penalty == 0) order.sparsity.reset();
  if (keys.noise == 0 || (sums > 1 && !order.moves)) order.noise.reset();
}

}  // namespace qs::train
