// SPDX-License-Identifier: MIT
//
// Density control by the errors of several views, after FastGS (Ren et al. 2026, arXiv 2511.04283).
// A Gaussian is cloned or split only if a share of its own pixels has a large error in ten views
// that are drawn before each change (kernel/error_map.h). Large Gaussians are split by absolute
// gradients. Opacities are limited after every change, so that Gaussians behind others keep a
// gradient. After the last reset, Gaussians that stay faint are removed.
//
// The published thresholds are numbers of pixels, chosen for each scene. Here they are shares, so
// that one setting holds for photographs of every size. Two published rules are left out: of the
// nearly transparent Gaussians, the published code removes a few that it draws by lot, while this
// file removes all; and it removes the Gaussians with the most wrong pixels, which are few.
#include "learn/run/density_rules.h"

namespace qs::train {
namespace {

constexpr int kAfterIteration = 500;
constexpr int kInterval = 500;  // iterations between changes
constexpr int kScoredViews = 10;
constexpr double kLeastShare = 0.03;  // of the Gaussian's pixels
constexpr double kCloneThreshold = 2e-4;
constexpr double kCloned = 0.005;  // times the extent: smaller ones are cloned, larger ones split
constexpr double kMostOpacity = 0.8;
constexpr int kManySumsFrom = 20'000;

// The mean absolute gradient above which large Gaussians are split.
double split_threshold(const TrainSettings& settings) {
  return settings.many_gaussians ? 3e-4 : 7e-4;
}

// True if Gaussians are added and removed between this iteration and the next.
bool fastgs_changes_after(int iteration) {
  return iteration > kAfterIteration && iteration < kDensityEnd && iteration % kInterval == 0;
}

std::vector<Candidate> fastgs_candidates(const IterationContext& context,
                                         const GaussianFacts& facts) {
  const double threshold = split_threshold(context.settings);
  std::vector<Candidate> candidates;
  for (std::uint32_t i = 0; i < facts.size(); ++i) {
    if (facts.counts.flagged_share(i) < kLeastShare) continue;
    const bool splits = largest_scale(facts, i) > kCloned * context.extent;
    const double urgency = splits ? static_cast<double>(facts.density.mean_absolute(i)) / threshold
                                  : static_cast<double>(facts.density.mean(i)) / kCloneThreshold;
    if (urgency > 1) candidates.push_back({i, urgency, splits});
  }
  return candidates;
}

/// Iterations between the steps of the coefficients of colour beyond DC, and of all other values,
/// with --sum-gradients.
struct StepIntervals {
  int rest, others;
};

StepIntervals intervals_in(int iteration) {
  if (iteration <= kDensityEnd) return {16, 1};
  return iteration <= kManySumsFrom ? StepIntervals{32, 32} : StepIntervals{64, 64};
}

}  // namespace

bool fastgs_absolute_gradients(const TrainSettings& /*settings*/) { return true; }

bool fastgs_changes_before(const TrainSettings& settings, int iteration) {
  return fastgs_changes_after(iteration - 1) || resets_after(settings, iteration - 1) ||
         final_prune_after(iteration - 1, kDensityEnd);
}

int fastgs_scored_views(const TrainSettings& /*settings*/, int iteration) {
  return fastgs_changes_after(iteration - 1) ? kScoredViews : 0;
}

void fastgs_plan(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  plan.keep_all(facts, context.iteration);
  if (fastgs_changes_after(context.iteration - 1)) {
    plan.resets_statistics = true;
    clone_and_split(context, facts, fastgs_candidates(context, facts), plan);
    prune(context, kLeastOpacity, plan);
    limit_opacities(kMostOpacity, plan);
  }
  if (resets_after(context.settings, context.iteration - 1)) limit_opacities(kResetOpacity, plan);
  if (final_prune_after(context.iteration - 1, kDensityEnd)) final_prune(plan);
}

StepOrder fastgs_step(const IterationContext& context) {
  StepOrder order = context.step();
  order.counts_density = context.iteration < kDensityEnd;
  order.moves = !fastgs_changes_after(context.iteration) &&
                !final_prune_after(context.iteration, kDensityEnd);
  if (context.settings.sum_gradients) {
    const StepIntervals intervals = intervals_in(context.iteration);
    order.sums = true;
    order.moves = order.moves && context.iteration % intervals.others == 0;
    order.rest_waits = context.iteration % intervals.rest != 0;
  }
  return order;
}

}  // namespace qs::train
