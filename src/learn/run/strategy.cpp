// SPDX-License-Identifier: MIT
#include "learn/run/strategy.h"

#include <algorithm>
#include <array>

#include "base/fail.h"

namespace qs::train {
namespace {

constexpr std::array kStrategies = {
    Strategy{"adc", "adaptive density control, as published with 3DGS", 2.5e-2, 0.1, 1, 0,
             adc_changes_before, adc_plan, adc_step, adc_absolute_gradients},
    Strategy{"mcmc", "relocates nearly transparent Gaussians (3DGS as Markov Chain Monte Carlo)",
             5e-2, 0.5, 0.1, 1'000'000, mcmc_changes_before, mcmc_plan, mcmc_step},
    Strategy{.name = "dash",
             .summary = "begins with small photographs and few Gaussians (DashGaussian)",
             .opacity_rate = 2.5e-2,
             .initial_opacity = 0.1,
             .initial_scale = 1,
             .default_max_gaussians = 0,
             .changes_before = dash_changes_before,
             .plan = dash_plan,
             .step = dash_step,
             .reduces_photographs = true},
    Strategy{"fastgs", "adds Gaussians where several views have large errors (FastGS)", 2.5e-2, 0.1,
             1, 0, fastgs_changes_before, fastgs_plan, fastgs_step, fastgs_absolute_gradients,
             fastgs_scored_views},
    Strategy{.name = "mask",
             .summary = "learns which Gaussians to drop (Compact-3DGS, with colours as in adc)",
             .opacity_rate = 5e-2,
             .initial_opacity = 0.1,
             .initial_scale = 1,
             .default_max_gaussians = 0,
             .changes_before = mask_changes_before,
             .plan = mask_plan,
             .step = mask_step,
             .has_masks = true},
};

}  // namespace

std::span<const Strategy> strategies() { return kStrategies; }

const Strategy& find_strategy(std::string_view name) {
  const auto found = std::find_if(kStrategies.begin(), kStrategies.end(),
                                  [&](const Strategy& row) { return row.name == name; });
  if (found == kStrategies.end()) fail(ErrorKind::usage, "--strategy: '{}' is no strategy", name);
  return *found;
}

}  // namespace qs::train
