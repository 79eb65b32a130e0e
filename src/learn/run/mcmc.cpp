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

#include "learn/gradient/relocation.h"
#include "learn/run/density_rules.h"

namespace qs::train {
namespace {

constexpr double kGrowth = 1.05;
constexpr double kNoise = 5e5;  // times the rate of the means and the covariance
constexpr double kOpacityWeight = 0.01, kScaleWeight = 0.01;

// Opacity and scale of `copies` Gaussians that replace one Gaussian.
void share(Plan& p, std::size_t i, int copies) {
  const Relocation shared = relocated(opacity(p, i), copies);
  const double kept = std::clamp(shared.opacity, kDeadOpacity, 1 - 1e-7);
  p.opacity_logits[i] = static_cast<float>(logit_of(kept));
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
    const auto found = std::ranges::upper_bound(sums, sum * random.uniform(k));
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
  const auto sources = drawn(plan, alive, dead.size(), context.random(RandomUse::relocate));
  share_sources(plan, sources);
  for (std::size_t k = 0; k < dead.size(); ++k) plan.replace(dead[k], sources[k]);
}

void grow(const IterationContext& context, Plan& plan) {
  const auto wanted = static_cast<std::size_t>(kGrowth * static_cast<double>(plan.size()));
  const std::size_t target = std::min(context.max_gaussians(), wanted);
  if (target <= plan.size()) return;
  std::vector<std::uint32_t> all(plan.size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  const auto sources = drawn(plan, all, target - plan.size(), context.random(RandomUse::add));
  share_sources(plan, sources);
  for (const std::uint32_t i : sources) plan.add_copy_of(i);
}

}  // namespace

void mcmc_change(const IterationContext& context, const GaussianFacts& /*facts*/, Plan& plan) {
  relocate_dead(context, plan);
  grow(context, plan);
}

void mcmc_step(const IterationContext& context, StepOrder& order) {
  const double unit = context.extent;
  order.sparsity = Sparsity{kOpacityWeight, kScaleWeight / unit};
  order.noise =
      Noise{{kNoise * context.rates.mean / (unit * unit)}, context.random(RandomUse::noise)};
}

}  // namespace qs::train
