// SPDX-License-Identifier: MIT
//
// Learned masks (Compact 3D Gaussian Representation, Lee et al., CVPR 2024, arXiv 2311.13681, with
// the constants of its published code): adaptive density control, in which every Gaussian has a
// mask that is trained (kernel/gradient/mask.h). The mean mask has a share in the loss, so
// Gaussians that the photographs do not need are masked out, and removed at the next change. After
// densification they are removed every 1,000 iterations. A clone and the children of a split have
// the mask of their Gaussian.
#include "learn/run/density_rules.h"
#include "learn/run/field_model.h"

namespace qs::train {
namespace {

constexpr int kMaskInterval = 1000;
constexpr double kMaskRate = 0.01, kMaskWeight = 5e-4;

bool masks_prune_after(int iteration) {
  return iteration >= kDensityEnd && iteration % kMaskInterval == 0;
}

}  // namespace

bool mask_changes_before(const TrainSettings& settings, int iteration) {
  return adc_changes_before(settings, iteration) || masks_prune_after(iteration - 1);
}

void mask_plan(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  adc_plan(context, facts, plan);
  if (masks_prune_after(context.iteration - 1)) plan.resets_statistics = true;
  if (!plan.resets_statistics) return;  // only opacities change
  plan.keep_if(
      [&](std::size_t i) { return !masked_out(double{facts.mask_logits[plan.sources[i]]}); });
}

StepOrder mask_step(const IterationContext& context) {
  StepOrder order = adc_step(context);
  order.moves = order.moves && !masks_prune_after(context.iteration);
  order.rates.mask = kMaskRate;
  order.mask_weight = kMaskWeight;
  order.field_rate = field_rate_at(context.iteration);
  return order;
}

}  // namespace qs::train
