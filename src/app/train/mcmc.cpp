// SPDX-License-Identifier: MIT
//
// 3DGS as Markov Chain Monte Carlo (Kheradmand et al. 2024, arXiv 2404.09591, with the defaults of
// the published code). Nearly transparent Gaussians move to others, which share their opacity
// (equation 9), the number grows by 5 % up to a limit, and noise moves nearly transparent ones.
#include <algorithm>
#include <cmath>

#include "app/train/strategy.h"
#include "raster/kernel/activation.h"
#include "raster/kernel/gradient/activation.h"
#include "raster/kernel/random.h"

namespace qs::train {
namespace {

constexpr int kInterval = 100, kAfter = 500, kEnd = 25'000;
constexpr double kDeadOpacity = 0.005, kGrowth = 1.05;
constexpr int kMostCopies = 51;
constexpr double kNoise = 5e5, kNoiseSlope = 100;
constexpr double kOpacityWeight = 0.01, kScaleWeight = 0.01;

// Whether Gaussians are moved and added between this iteration and the next.
bool changes_after(int iteration) {
  return iteration > kAfter && iteration < kEnd && iteration % kInterval == 0;
}

// Adds the gradients of 0.01 mean(opacity) + 0.01 mean(scale).
void regularise(const StepContext& context) {
  const Parameters& p = context.model.parameters;
  const double count = static_cast<double>(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double o = opacity(p, i);
    context.gradients.by.opacity_logits[i] +=
        static_cast<float>(opacity_gradient(o, kOpacityWeight / count));
    const glm::dvec3 scale = glm::exp(glm::dvec3(p.log_scales[i]));
    context.gradients.by.log_scales[i] += glm::vec3(scale * (kScaleWeight / (3 * count)));
  }
}

double binomial(int n, int k) {
  double value = 1;
  for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
  return value;
}

// Equation 9: opacity and scale of `copies` Gaussians in the place of one.
void share(Parameters& p, std::size_t i, int copies) {
  const double before = opacity(p, i);
  const double after = 1 - std::pow(1 - before, 1.0 / copies);
  double sum = 0;
  for (int n = 1; n <= copies; ++n) {
    for (int k = 0; k < n; ++k) {
      sum +=
          binomial(n - 1, k) * (k % 2 == 0 ? 1 : -1) * std::pow(after, k + 1) / std::sqrt(k + 1.0);
    }
  }
  const double kept = std::clamp(after, kDeadOpacity, 1 - 1e-7);
  p.opacity_logits[i] = static_cast<float>(std::log(kept / (1 - kept)));
  const double factor = before / sum;
  if (factor > 0 && std::isfinite(factor))
    p.log_scales[i] += glm::vec3(static_cast<float>(std::log(factor)));
}

// `count` of the candidates, drawn by opacity with replacement.
std::vector<std::uint32_t> drawn(const Parameters& p, const std::vector<std::uint32_t>& candidates,
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
void share_sources(ModelState& model, const std::vector<std::uint32_t>& sources) {
  std::vector<int> copies(model.size(), 1);
  for (const std::uint32_t i : sources) copies[i] = std::min(copies[i] + 1, kMostCopies);
  for (std::size_t i = 0; i < copies.size(); ++i) {
    if (copies[i] == 1) continue;
    share(model.parameters, i, copies[i]);
    model.clear_moments(i);
  }
}

void relocate_dead(const ModelContext& context) {
  ModelState& model = context.model;
  std::vector<std::uint32_t> dead, alive;
  for (std::uint32_t i = 0; i < model.size(); ++i)
    (opacity(model.parameters, i) <= kDeadOpacity ? dead : alive).push_back(i);
  if (dead.empty() || alive.empty()) return;
  const auto sources = drawn(model.parameters, alive, dead.size(),
                             Random::of(context.settings.seed, RandomUse::relocate,
                                        static_cast<std::uint64_t>(context.iteration)));
  share_sources(model, sources);
  cpu::train::for_each_array(
      [&](std::size_t values, auto& array) {
        for (std::size_t k = 0; k < dead.size(); ++k) {
          std::copy_n(array.begin() + static_cast<std::ptrdiff_t>(sources[k] * values), values,
                      array.begin() + static_cast<std::ptrdiff_t>(dead[k] * values));
        }
      },
      model.parameters);
}

void grow(const ModelContext& context) {
  ModelState& model = context.model;
  const std::size_t limit =
      find_strategy(context.settings.strategy).max_gaussians(context.settings);
  const auto wanted = static_cast<std::size_t>(kGrowth * static_cast<double>(model.size()));
  const std::size_t target = std::min(limit, wanted);
  if (target <= model.size()) return;
  std::vector<std::uint32_t> all(model.size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  const auto sources = drawn(model.parameters, all, target - model.size(),
                             Random::of(context.settings.seed, RandomUse::add,
                                        static_cast<std::uint64_t>(context.iteration)));
  share_sources(model, sources);
  model.duplicate(sources);
}

void add_noise(const StepContext& context) {
  Parameters& p = context.model.parameters;
  const Random random = Random::of(context.settings.seed, RandomUse::noise,
                                   static_cast<std::uint64_t>(context.iteration));
  context.pool.for_chunks(p.size(), 1024, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const double size =
          kNoise * context.rates.mean * opacity_of(-kNoiseSlope * (opacity(p, i) - kDeadOpacity));
      const Covariance3<double> c =
          covariance_of(glm::dvec3(p.log_scales[i]), unit_rotation(glm::dquat(p.rotations[i])));
      const glm::dvec3 n = random.normal3(i);
      const glm::vec3 offset(size * glm::dvec3(c.xx * n.x + c.xy * n.y + c.xz * n.z,
                                               c.xy * n.x + c.yy * n.y + c.yz * n.z,
                                               c.xz * n.x + c.yz * n.y + c.zz * n.z));
      const glm::vec3 moved = p.means[i] + offset;
      const float sum = moved.x + moved.y + moved.z;
      if (sum - sum == 0.0f) p.means[i] = moved;  // finite
    }
  });
}

}  // namespace

void mcmc_prepare(const ModelContext& context) {
  if (!changes_after(context.iteration - 1)) return;
  relocate_dead(context);
  grow(context);
}

void mcmc_step(const StepContext& context) {
  if (!changes_after(context.iteration)) {
    regularise(context);
    context.take_step();
  }
  add_noise(context);
}

}  // namespace qs::train
