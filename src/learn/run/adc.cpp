// SPDX-License-Identifier: MIT
//
// Adaptive density control (Kerbl et al. 2023, with the defaults of the published code). Gaussians
// that the loss wants to move far on the image are cloned if they are small and split in two if
// they are large; nearly transparent Gaussians are removed. From time to time all opacities are
// reset to nearly 0; Gaussians that the loss does not need stay transparent and are removed. The
// published rule that removes Gaussians larger than 20 pixels never acts in the published code, and
// is left out.
#include "learn/run/density_rules.h"

namespace qs::train {
namespace {

constexpr int kAdcInterval = 100, kFirst = 600;
constexpr double kGradientThreshold = 2e-4;
constexpr double kAbsoluteThreshold = 4e-4;  // AbsGS (Ye et al. 2024, arXiv 2404.10484)
constexpr double kSmall = 0.01;              // times the extent

// True if Gaussians are added and removed between this iteration and the next.
bool adc_changes_after(int iteration) {
  return iteration >= kFirst && iteration < kDensityEnd && iteration % kAdcInterval == 0;
}

bool adc_prunes_after(const TrainSettings& settings, int iteration) {
  return settings.final_prunes && final_prune_after(iteration, kDensityEnd);
}

std::vector<Candidate> adc_candidates(const IterationContext& context, const GaussianFacts& facts) {
  std::vector<Candidate> candidates;
  for (std::uint32_t i = 0; i < facts.size(); ++i) {
    const double moved = static_cast<double>(facts.density.mean(i)) / kGradientThreshold;
    const double pulled =
        context.settings.absolute_gradients
            ? static_cast<double>(facts.density.mean_absolute(i)) / kAbsoluteThreshold
            : moved;
    if (!(moved > 1) && !(pulled > 1)) continue;  // for most, so the scale need not be computed
    const bool splits = largest_scale(facts, i) > kSmall * context.extent;
    const double urgency = splits ? pulled : moved;
    if (urgency > 1) candidates.push_back({i, urgency, splits});
  }
  return candidates;
}

}  // namespace

bool adc_absolute_gradients(const TrainSettings& settings) { return settings.absolute_gradients; }

bool adc_changes_before(const TrainSettings& settings, int iteration) {
  return adc_changes_after(iteration - 1) || resets_after(settings, iteration - 1) ||
         adc_prunes_after(settings, iteration - 1);
}

void adc_plan(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  plan.keep_all(facts, context.iteration);
  if (adc_changes_after(context.iteration - 1)) {
    plan.resets_statistics = true;
    clone_and_split(context, facts, adc_candidates(context, facts), plan);
    prune(context, kLeastOpacity, plan);
  }
  if (resets_after(context.settings, context.iteration - 1)) limit_opacities(kResetOpacity, plan);
  if (adc_prunes_after(context.settings, context.iteration - 1)) final_prune(plan);
}

StepOrder adc_step(const IterationContext& context) {
  StepOrder order = context.step();
  order.counts_density = context.iteration < kDensityEnd;
  order.moves = !adc_changes_after(context.iteration) &&
                !adc_prunes_after(context.settings, context.iteration);
  return order;
}

}  // namespace qs::train
