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

constexpr double kLeastShare = 0.03;  // share of the Gaussian's pixels
constexpr double kCloned = 0.005;  // times the extent: smaller ones are cloned, larger ones split
constexpr double kMostOpacity = 0.8;
constexpr int kManySumsFrom = 20'000;

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

void fastgs_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan) {
  // The mean absolute gradient above which large Gaussians are split.
  const double split = context.settings.many_gaussians ? 3e-4 : 7e-4;
  const CandidateRule rule{kCloned, split, kLeastShare};
  clone_and_split(context, facts, find_candidates(context, facts, rule), plan);
  prune(context, kLeastOpacity, plan);
  limit_opacities(kMostOpacity, plan);
}

void fastgs_step(const IterationContext& context, StepOrder& order) {
  if (!context.settings.sum_gradients) return;
  const StepIntervals intervals = intervals_in(context.iteration);
  order.sums = true;
  order.moves = order.moves && context.iteration % intervals.others == 0;
  order.rest_waits = context.iteration % intervals.rest != 0;
}

}  // namespace qs::train
