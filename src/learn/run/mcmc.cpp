// SPDX-License-Identifier: MIT
//
// 3DGS as Markov Chain Monte Carlo (Kheradmand et al. 2024, arXiv 2404.09591, with the defaults of
// the published code). Nearly transparent Gaussians move to other Gaussians and share their opacity
// (equation 9). The number of Gaussians grows by 5 % up to a limit. Noise moves nearly transparent
// Gaussians. Noise and the weight on scales are in units of the cameras' extent. In the published
// code they are in the data set's units. Its noise is the cube of a length, so it scatters
// Gaussians in large worlds.
#include <algorithm>
#include <cmath>

#include "learn/run/density_rules.h"
#include "learn/step/relocation.h"
#include "raster/kernel/random.h"

namespace qs::train {
namespace {

constexpr int kMcmcInterval = 100, kAfter = 500, kMcmcEnd = 25'000;
constexpr double kGrowth = 1.05;
constexpr double kNoise = 5e5;  // times the rate of the means and the covariance
constexpr double kOpacityWeight = 0.01, kScaleWeight = 0.01;

// True if Gaussians are moved and added between this iteration and the next.
bool mcmc_changes_after(int iteration) {
  return iteration > kAfter && iteration < kMcmcEnd && iteration % kMcmcInterval == 0;
}

bool mcmc_prunes_after(const TrainSettings& settings, int iteration) {
  return settings.final_prunes && final_prune_after(iteration, kMcmcEnd);
}

// Opacity and scale of `copies` Gaussians that replace one Gaussian.
void share(Plan& p, std::size_t i, int copies) {
  const Relocation shared = relocated(opacity(p, i), copies);
  const double kept = std::clamp(shared.opacity, kDeadOpacity, 1 - 1e-7);
  p.opacity_logits[i] = static_cast<float>(std::log(kept / (1 - kept)));
  p.log_scales[i] += glm::vec3(static_cast<float>(std::log(shared.scale_factor)));
}

// Draws `count` candidates by opacity, with replacement.
std::vector<std::uint32_t> drawn(const Plan& p, const std::vector<std::uint32_t>& candidates,
                                 std::size_t count, const Random& random) {
  std::vector<double> sums;
  double sum = 0;
  for (const std::uint32_t i : candidates) sums.push_back(sum += opacity(p, i));
  std::vector<std::uint32_t> result;
  for (std::size_t k = 0; k < count; ++k) {
    const auto found = std::upper_bound(sums.begin(), sums.end(), sum * random.uniform(k));
    const auto at = std::min(static_cast<std::size_t>(found - sums.begin()), sums.size() - 1);
    result.push_back(candidates[at]);
  }
  return result;
}

// Every source shares its place with the copies that were drawn from it, and loses its moments.
void share_sources(Plan& plan, const std::vector<std::uint32_t>& sources) {
  std::vector<int> copies(plan.size(), 1);
  for (const std::uint32_t i : sources) copies[i] = std::min(copies[i] + 1, kMostCopies);
  for (std::size_t i = 0; i < copies.size(); ++i) {
    if (copies[i] == 1) continue;
    share(plan, i, copies[i]);
    plan.moment_sources[i] = Plan::kZeros;
  }
}

void relocate_dead(const IterationContext& context, Plan& plan) {
  std::vector<std::uint32_t> dead, alive;
  for (std::uint32_t i = 0; i < plan.size(); ++i)
    (opacity(plan, i) <= kDeadOpacity ? dead : alive).push_back(i);
  if (dead.empty() || alive.empty()) return;
  const auto sources = drawn(plan, alive, dead.size(),
                             Random::of(context.settings.seed, RandomUse::relocate,
                                        static_cast<std::uint64_t>(context.iteration)));
  share_sources(plan, sources);
  for (std::size_t k = 0; k < dead.size(); ++k) plan.replace(dead[k], sources[k]);
}

void grow(const IterationContext& context, Plan& plan) {
  const std::size_t limit =
      find_strategy(context.settings.strategy).max_gaussians(context.settings);
  const auto wanted = static_cast<std::size_t>(kGrowth * static_cast<double>(plan.size()));
  const std::size_t target = std::min(limit, wanted);
  if (target <= plan.size()) return;
  std::vector<std::uint32_t> all(plan.size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  const auto sources = drawn(plan, all, target - plan.size(),
                             Random::of(context.settings.seed, RandomUse::add,
                                        static_cast<std::uint64_t>(context.iteration)));
  share_sources(plan, sources);
  for (const std::uint32_t i : sources) plan.add_copy_of(i);
}

}  // namespace

bool mcmc_changes_before(const TrainSettings& settings, int iteration) {
  return mcmc_changes_after(iteration - 1) || mcmc_prunes_after(settings, iteration - 1);
}

void mcmc_plan(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  plan.keep_all(facts, context.iteration);
  plan.resets_statistics = true;
  if (mcmc_prunes_after(context.settings, context.iteration - 1)) {
    final_prune(plan);
    return;
  }
  relocate_dead(context, plan);
  grow(context, plan);
}

StepOrder mcmc_step(const IterationContext& context) {
  StepOrder order = context.step();
  order.moves = !mcmc_changes_after(context.iteration) &&
                !mcmc_prunes_after(context.settings, context.iteration);
  const double unit = context.extent;
  order.sparsity = Sparsity{kOpacityWeight, kScaleWeight / unit};
  order.noise = Noise{kNoise * context.rates.mean / (unit * unit),
                      Random::of(context.settings.seed, RandomUse::noise,
                                 static_cast<std::uint64_t>(context.iteration))};
  return order;
}

}  // namespace qs::train
