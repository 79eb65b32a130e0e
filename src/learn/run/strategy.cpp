// SPDX-License-Identifier: MIT
#include "learn/run/strategy.h"

#include <algorithm>
#include <array>

#include "base/fail.h"
#include "learn/run/density_rules.h"
#include "learn/run/field_model.h"

namespace qs::train {
namespace {

constexpr int kMaskInterval = 1000;

constexpr std::array kStrategies = {
    Strategy{.name = "paced",
             .summary = "reaches a number of Gaussians on a schedule that follows the run",
             .resets_opacities = false,
             .counts_density = false,
             .needs_absolute_gradients = true,
             .usual_iterations = paced_iterations,
             .sh_steps = 25,
             .changes_after = paced_changes_after,
             .change = paced_change,
             .adjust_step = paced_step},
    Strategy{.name = "adc",
             .summary = "adaptive density control, as published with 3DGS",
             .change = adc_change},
    Strategy{.name = "mcmc",
             .summary = "relocates nearly transparent Gaussians (3DGS as Markov Chain Monte Carlo)",
             .opacity_rate = 5e-2,
             .initial_opacity = 0.5,
             .initial_scale = 0.1,
             .default_max_gaussians = 1'000'000,
             .end = 25'000,
             .resets_opacities = false,
             .counts_density = false,
             .change = mcmc_change,
             .adjust_step = mcmc_step},
    Strategy{.name = "dash",
             .summary = "begins with small photographs and few Gaussians (DashGaussian)",
             .follows_run = true,
             .reduces_photographs = true,
             .change = dash_change},
    Strategy{.name = "fastgs",
             .summary = "adds Gaussians where several views have large errors (FastGS)",
             .first_change = 1000,
             .interval = 500,
             .always_prunes_at_end = true,
             .needs_absolute_gradients = true,
             .counted_views = 10,
             .change = fastgs_change,
             .adjust_step = fastgs_step},
    Strategy{.name = "mask",
             .summary = "learns which Gaussians to drop (Compact-3DGS, with colours as in adc)",
             .opacity_rate = 5e-2,
             .has_masks = true,
             .change = adc_change,
             .adjust_step = mask_step},
};

constexpr double kMaskRate = 0.01, kMaskWeight = 5e-4;

}  // namespace

std::size_t IterationContext::max_gaussians() const {
  return settings.max_gaussians > 0 ? settings.max_gaussians
                                    : find_strategy(settings.strategy).default_max_gaussians;
}

Strategy::Events Strategy::events_after(const TrainSettings& settings, int iteration,
                                        const RunFacts& run) const {
  const int last = end_in(settings);
  // Published up to 24,000 of 30,000 iterations.
  const int reset_end =
      follows_run ? static_cast<int>(4L * settings.iterations / 5) + 1 : kDensityEnd;
  const bool usual = iteration >= first_change && iteration < last && iteration % interval == 0;
  return {.change = changes_after != nullptr ? changes_after(run, iteration) : usual,
          .final_prune =
              (always_prunes_at_end || settings.final_prunes) && final_prune_after(iteration, last),
          .mask_prune = has_masks && iteration >= last && iteration % kMaskInterval == 0,
          .opacity_reset = resets_opacities && resets_after(settings, iteration, reset_end)};
}

bool Strategy::changes_before(const TrainSettings& settings, int iteration,
                              const RunFacts& run) const {
  const Events events = events_after(settings, iteration - 1, run);
  return events.change_the_set() || events.opacity_reset;
}

int Strategy::scored_views(const TrainSettings& settings, int iteration,
                           const RunFacts& run) const {
  return events_after(settings, iteration - 1, run).change ? counted_views : 0;
}

void Strategy::plan(const IterationContext& context, const GaussianFacts& facts, Plan& plan) const {
  const Events events = events_after(context.settings, context.iteration - 1, context.run);
  plan.keep_all(facts, context.iteration);
  plan.resets_statistics = events.change_the_set();
  if (events.change) change(context, facts, plan);
  if (events.opacity_reset) limit_opacities(kResetOpacity, plan);
  if (events.final_prune) remove_faint(kFinalOpacity, plan);
  if (has_masks && events.change_the_set())
    plan.keep_if(
        [&](std::size_t i) { return !qs::masked_out(double{facts.mask_logits[plan.sources[i]]}); });
}

StepOrder Strategy::step(const IterationContext& context) const {
  StepOrder order;
  order.iteration = context.iteration;
  order.rates = context.rates;
  order.counts_density = counts_density && context.iteration < end_in(context.settings);
  order.moves = !events_after(context.settings, context.iteration, context.run).change_the_set();
  if (adjust_step != nullptr) adjust_step(context, order);
  return order;
}

std::span<const Strategy> strategies() { return kStrategies; }

const Strategy& default_strategy() { return kStrategies.front(); }

const Strategy& find_strategy(std::string_view name) {
  const auto found = std::ranges::find(kStrategies, name, &Strategy::name);
  if (found == kStrategies.end()) fail(ErrorKind::usage, "--strategy: '{}' is no strategy", name);
  return *found;
}

// Learned masks (Compact 3D Gaussian Representation, Lee et al., CVPR 2024, arXiv 2311.13681, with
// the constants of its published code): adaptive density control, in which every Gaussian has a
// mask that is trained (kernel/gradient/mask.h). The mean mask has a share in the loss, so
// Gaussians that the photographs do not need are masked out, and removed at the next change. After
// densification they are removed every 1,000 iterations. A clone and the children of a split have
// the mask of their Gaussian.
void mask_step(const IterationContext& context, StepOrder& order) {
  order.rates.mask = kMaskRate;
  order.mask_weight = kMaskWeight;
  order.field_rate = field_rate_at(context.iteration);
}

}  // namespace qs::train
