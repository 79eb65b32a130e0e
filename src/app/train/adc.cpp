// SPDX-License-Identifier: MIT
//
// Adaptive density control (Kerbl et al. 2023, with the defaults of the published code). Gaussians
// that the loss wants to move far on the image are cloned if they are small and split in two if
// they are large; nearly transparent Gaussians are removed. From time to time all opacities are
// reset to nearly 0; Gaussians that the loss does not need stay transparent and are removed. The
// published rule that removes Gaussians larger than 20 pixels never acts in the published code, and
// is left out.
#include <algorithm>
#include <cmath>

#include "app/train/strategy.h"
#include "raster/kernel/gradient/activation.h"
#include "raster/kernel/random.h"

namespace qs::train {
namespace {

constexpr int kAdcInterval = 100, kFirst = 600,
              kAdcEnd = 15'000;  // densification: from the first to before the last
constexpr int kResetInterval = 3000, kWhiteReset = 500;
constexpr float kGradientThreshold = 2e-4f;
constexpr double kSmall = 0.01, kHuge = 0.1;  // times the extent
constexpr double kLeastOpacity = 0.005, kResetOpacity = 0.01;
constexpr double kSplitShrink = 1.6;

// True if Gaussians are added and removed between this iteration and the next.
bool adc_changes_after(int iteration) {
  return iteration >= kFirst && iteration < kAdcEnd && iteration % kAdcInterval == 0;
}

// True if opacities are reset between this iteration and the next.
bool resets_after(const TrainSettings& settings, int iteration) {
  const bool usual = iteration > 0 && iteration < kAdcEnd && iteration % kResetInterval == 0;
  return usual || (settings.white() && iteration == kWhiteReset);
}

// The Gaussians to clone or split, ascending; if the limit does not allow all of them, the
// Gaussians with the largest gradients.
std::vector<std::uint32_t> chosen(const IterationContext& context, const GaussianFacts& facts) {
  std::vector<std::uint32_t> rows;
  for (std::uint32_t i = 0; i < facts.size(); ++i) {
    if (facts.density.mean(i) > kGradientThreshold) rows.push_back(i);
  }
  const std::size_t limit =
      find_strategy(context.settings.strategy).max_gaussians(context.settings);
  if (limit == 0) return rows;
  const std::size_t room = limit > facts.size() ? limit - facts.size() : 0;
  if (rows.size() <= room) return rows;
  std::stable_sort(rows.begin(), rows.end(), [&](std::uint32_t a, std::uint32_t b) {
    return facts.density.mean(a) > facts.density.mean(b);
  });
  rows.resize(room);
  std::sort(rows.begin(), rows.end());
  return rows;
}

// Replaces Gaussian `child` of the plan, a copy, by a smaller one at a point drawn from it.
void shrink_child(Plan& plan, std::size_t child, const glm::quat& rotation,
                  const glm::dvec3& normal) {
  const glm::dmat3 axes = glm::mat3_cast(unit_rotation(glm::dquat(rotation)));
  const glm::dvec3 scale = glm::exp(glm::dvec3(plan.log_scales[child]));
  plan.means[child] += glm::vec3(axes * (scale * normal));
  plan.log_scales[child] -= static_cast<float>(std::log(kSplitShrink));
}

void clone_and_split(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  std::vector<std::uint32_t> clones, splits;
  for (const std::uint32_t i : chosen(context, facts)) {
    const bool small = largest_scale(facts, i) <= kSmall * context.extent;
    (small ? clones : splits).push_back(i);
  }
  for (const std::uint32_t i : clones) plan.add_copy_of(i);
  const std::size_t first_child = plan.size();
  for (int copy = 0; copy < 2; ++copy) {
    for (const std::uint32_t i : splits) plan.add_copy_of(i);
  }
  const Random random = Random::of(context.settings.seed, RandomUse::split,
                                   static_cast<std::uint64_t>(context.iteration));
  for (std::size_t child = first_child; child < plan.size(); ++child) {
    shrink_child(plan, child, facts.rotations[plan.sources[child]],
                 random.normal3(child - first_child));
  }
  // The children replace the Gaussians that were split, which are in ascending order.
  auto split = splits.begin();
  plan.keep_if([&](std::size_t i) {
    if (split == splits.end() || *split != i) return true;
    ++split;
    return false;
  });
}

double logit_of(double opacity) { return std::log(opacity / (1 - opacity)); }

void prune(const IterationContext& context, Plan& plan) {
  const bool after_reset = context.iteration - 1 > kResetInterval;
  const double least_logit = logit_of(kLeastOpacity);
  const double huge_log = std::log(kHuge * context.extent);
  plan.keep_if([&](std::size_t i) {
    const glm::vec3& s = plan.log_scales[i];
    const bool huge = after_reset && std::max(s.x, std::max(s.y, s.z)) > huge_log;
    return plan.opacity_logits[i] >= least_logit && !huge;
  });
}

void reset_opacities(Plan& plan) {
  const auto most = static_cast<float>(logit_of(kResetOpacity));
  for (float& logit : plan.opacity_logits) logit = std::min(logit, most);
  plan.clears_opacity_moments = true;
}

}  // namespace

bool adc_changes_before(const TrainSettings& settings, int iteration) {
  return adc_changes_after(iteration - 1) || resets_after(settings, iteration - 1);
}

void adc_plan(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  plan.keep_all(facts, context.iteration);
  if (adc_changes_after(context.iteration - 1)) {
    plan.resets_statistics = true;
    clone_and_split(context, facts, plan);
    prune(context, plan);
  }
  if (resets_after(context.settings, context.iteration - 1)) reset_opacities(plan);
}

StepOrder adc_step(const IterationContext& context) {
  StepOrder order = context.step();
  order.counts_density = context.iteration < kAdcEnd;
  order.moves = !adc_changes_after(context.iteration);
  return order;
}

}  // namespace qs::train
