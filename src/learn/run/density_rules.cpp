// SPDX-License-Identifier: MIT
#include "learn/run/density_rules.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "learn/gradient/activation.h"

namespace qs::train {
namespace {

constexpr double kGradientThreshold = 2e-4;
constexpr double kSplitShrink = 1.6;
constexpr double kHuge = 0.1;  // times the extent
constexpr int kResetInterval = 3000, kWhiteReset = 500;
constexpr int kFirstFinalPrune = 18'000, kLastFinalPrune = 27'000, kFinalPruneInterval = 3000;

// Replaces Gaussian `child` of the plan, a copy, by a smaller one at a point drawn from it.
void shrink_child(Plan& plan, std::size_t child, const glm::quat& rotation,
                  const glm::dvec3& normal) {
  const glm::dmat3 axes = glm::mat3_cast(unit_rotation(glm::dquat(rotation)));
  const glm::dvec3 scale = glm::exp(glm::dvec3(plan.log_scales[child]));
  plan.means[child] += glm::vec3(axes * (scale * normal));
  plan.log_scales[child] -= static_cast<float>(std::log(kSplitShrink));
}

}  // namespace

std::vector<Candidate> find_candidates(const IterationContext& context, const GaussianFacts& facts,
                                       const CandidateRule& rule) {
  std::vector<Candidate> candidates;
  for (std::uint32_t i = 0; i < facts.size(); ++i) {
    if (facts.counts.flagged_share(i) < rule.least_share) continue;
    const double moved = static_cast<double>(facts.density.mean(i)) / kGradientThreshold;
    const double pulled =
        rule.absolute_threshold
            ? static_cast<double>(facts.density.mean_absolute(i)) / *rule.absolute_threshold
            : moved;
    if (!(moved > 1) && !(pulled > 1)) continue;  // for most, so the scale need not be computed
    const bool splits = largest_scale(facts, i) > rule.small * context.extent;
    const double urgency = splits ? pulled : moved;
    if (urgency > 1) candidates.push_back({i, urgency, splits});
  }
  return candidates;
}

void keep_most_urgent(std::size_t number, std::vector<Candidate>& candidates) {
  if (candidates.size() <= number) return;
  std::nth_element(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(number),
                   candidates.end(), [](const Candidate& a, const Candidate& b) {
                     return a.urgency != b.urgency ? a.urgency > b.urgency
                                                   : a.gaussian < b.gaussian;
                   });
  candidates.resize(number);
}

void clone_and_split(const IterationContext& context, const GaussianFacts& facts,
                     std::vector<Candidate> candidates, Plan& plan) {
  const std::size_t limit = context.max_gaussians();
  if (limit > 0) keep_most_urgent(limit > facts.size() ? limit - facts.size() : 0, candidates);
  std::ranges::sort(candidates, {}, &Candidate::gaussian);
  std::vector<std::uint32_t> clones, splits;
  for (const Candidate& each : candidates) (each.splits ? splits : clones).push_back(each.gaussian);
  for (const std::uint32_t i : clones) plan.add_copy_of(i);
  const std::size_t first_child = plan.size();
  for (int copy = 0; copy < 2; ++copy)
    for (const std::uint32_t i : splits) plan.add_copy_of(i);
  const Random random = context.random(RandomUse::split);
  for (std::size_t child = first_child; child < plan.size(); ++child)
    shrink_child(plan, child, facts.rotations[plan.sources[child]],
                 random.normal3(child - first_child));
  // The children replace the Gaussians that were split, which are in ascending order.
  auto split = splits.begin();
  plan.keep_if([&](std::size_t i) {
    if (split == splits.end() || *split != i) return true;
    ++split;
    return false;
  });
}

void prune(const IterationContext& context, double least_opacity, Plan& plan) {
  remove_faint(least_opacity, plan);
  if (context.iteration - 1 <= kResetInterval) return;
  const double huge_log = std::log(kHuge * context.extent);
  plan.keep_if([&](std::size_t i) {
    const glm::vec3& s = plan.log_scales[i];
    return !(std::max(s.x, std::max(s.y, s.z)) > huge_log);
  });
}

void remove_faint(double least_opacity, Plan& plan) {
  const double least_logit = logit_of(least_opacity);
  plan.keep_if([&](std::size_t i) { return plan.opacity_logits[i] >= least_logit; });
}

void limit_opacities(double most, Plan& plan) {
  const auto most_logit = static_cast<float>(logit_of(most));
  for (float& logit : plan.opacity_logits) logit = std::min(logit, most_logit);
  plan.clears_opacity_moments = true;
}

bool resets_after(const TrainSettings& settings, int iteration, int end) {
  const bool usual = iteration > 0 && iteration < end && iteration % kResetInterval == 0;
  return usual || (settings.white() && iteration == kWhiteReset);
}

bool final_prune_after(int iteration, int first) {
  return iteration >= std::max(first, kFirstFinalPrune) && iteration <= kLastFinalPrune &&
         iteration % kFinalPruneInterval == 0;
}

// Adaptive density control (Kerbl et al. 2023, with the defaults of the published code). Gaussians
// that the loss wants to move far on the image are cloned if they are small and split in two if
// they are large; nearly transparent Gaussians are removed. From time to time all opacities are
// reset to nearly 0; Gaussians that the loss does not need stay transparent and are removed. The
// published rule that removes Gaussians larger than 20 pixels never acts in the published code, and
// is left out.
void adc_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  constexpr double kAbsoluteThreshold = 4e-4;  // AbsGS (Ye et al. 2024, arXiv 2404.10484)
  CandidateRule rule{.small = 0.01};
  if (context.settings.absolute_gradients) rule.absolute_threshold = kAbsoluteThreshold;
  clone_and_split(context, facts, find_candidates(context, facts, rule), plan);
  prune(context, kLeastOpacity, plan);
}

}  // namespace qs::train
