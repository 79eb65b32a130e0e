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

constexpr double kGradientThreshold = 2e-4;
constexpr double kAbsoluteThreshold = 4e-4;  // AbsGS (Ye et al. 2024, arXiv 2404.10484)
constexpr double kSmall = 0.01;              // times the extent

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

void adc_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  clone_and_split(context, facts, adc_candidates(context, facts), plan);
  prune(context, kLeastOpacity, plan);
}

}  // namespace qs::train
