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

void adc_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  constexpr double kAbsoluteThreshold = 4e-4;  // AbsGS (Ye et al. 2024, arXiv 2404.10484)
  CandidateRule rule{.small = 0.01};
  if (context.settings.absolute_gradients) rule.absolute_threshold = kAbsoluteThreshold;
  clone_and_split(context, facts, find_candidates(context, facts, rule), plan);
  prune(context, kLeastOpacity, plan);
}

}  // namespace qs::train
