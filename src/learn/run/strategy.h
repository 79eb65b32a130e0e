// SPDX-License-Identifier: MIT
//
// A strategy changes the set of Gaussians while it is trained. It decides on the host, from a few
// numbers per Gaussian, so every backend supports all strategies. To add a strategy: a file with
// its function, declared here, a row in strategy.cpp and a test.
#pragma once

#include <span>
#include <string_view>

#include "learn/run/pace.h"
#include "learn/run/settings.h"
#include "learn/step/training_model.h"
#include "raster/kernel/random.h"

namespace qs::train {

inline constexpr int kDensityEnd = 15'000;  ///< the usual Strategy::end

/// The facts of a run that strategies need beside its settings.
struct RunFacts {
  std::size_t views = 1;     ///< training views
  std::uint64_t pixels = 0;  ///< of all training photographs
  Pace pace{30'000};
  /// The iteration after which the guard stopped growth (guard.h); 0: it did not.
  int stopped_after = 0;
};

/// An iteration, which counts from 1.
struct IterationContext {
  const TrainSettings& settings;
  int iteration;
  double extent;  ///< world units, see DataSet::extent()
  Rates rates;
  int last_factor = 1;  ///< the reduction of the last iteration's photograph
  RunFacts run = {};

  /// The random numbers of one purpose in this iteration.
  Random random(RandomUse use) const {
    return Random::of(settings.seed, use, static_cast<std::uint64_t>(iteration));
  }
  /// The largest number of Gaussians; 0: no limit.
  std::size_t max_gaussians() const;
};

/// One row per strategy. All times are iterations.
struct Strategy {
  const char* name = "";
  const char* summary = "";
  double opacity_rate = 2.5e-2;                     ///< learning rate of opacity logits
  double initial_opacity = 0.1, initial_scale = 1;  ///< see InitialGaussians
  std::size_t default_max_gaussians = 0;            ///< 0: no limit

  /// Gaussians are added, moved and removed after every iteration that is a multiple of `interval`,
  /// from `first_change` to before `end`.
  int first_change = 600, interval = 100, end = kDensityEnd;
  /// `end` is TrainSettings::reduced_until(), and the resets of opacities last for 4/5 of the run.
  bool follows_run = false;
  bool resets_opacities = true;       ///< see resets_after()
  bool always_prunes_at_end = false;  ///< as with TrainSettings::final_prunes
  /// The density statistics count every view before `end`.
  bool counts_density = true;
  bool needs_absolute_gradients = false;  ///< as with TrainSettings::absolute_gradients
  /// The number of training views whose pixels are counted for GaussianFacts::counts before
  /// Gaussians are added.
  int counted_views = 0;
  /// True if training begins with reduced photographs unless the user chose otherwise, and the rate
  /// of the means falls from ResolutionSchedule::details_from().
  bool reduces_photographs = false;
  /// True if every Gaussian has a mask that is trained, see kernel/gradient/mask.h. Gaussians that
  /// are masked out are removed at every change, and every 1,000 iterations after `end`.
  bool has_masks = false;
  /// The iterations of a run without a given length; null: as TrainSettings has them.
  int (*usual_iterations)(std::size_t views) = nullptr;
  int sh_steps = 0;  ///< the SH degree grows in every of so many parts of the run; 0: every 1,000
                     ///< iterations

  /// True if Gaussians are added, moved or removed after this iteration; null: by `first_change`,
  /// `interval` and `end`.
  bool (*changes_after)(const RunFacts& run, int iteration) = nullptr;
  /// Adds, moves and removes Gaussians in a plan that keeps all.
  void (*change)(const IterationContext& context, const GaussianFacts& facts, Plan& plan);
  /// Changes the usual order of the optimizer's step; null: it stays.
  void (*adjust_step)(const IterationContext& context, StepOrder& order) = nullptr;

  /// True if the density statistics need absolute gradients.
  bool absolute_gradients(const TrainSettings& settings) const {
    return needs_absolute_gradients || settings.absolute_gradients;
  }
  /// True if the plan changes the set of Gaussians before the iteration starts. The model is saved
  /// and evaluated before the change, as in the published code.
  bool changes_before(const TrainSettings& settings, int iteration, const RunFacts& run = {}) const;
  /// The number of views to count before the plan for this iteration; 0: none.
  int scored_views(const TrainSettings& settings, int iteration, const RunFacts& run = {}) const;
  /// Sets `plan`. Its memory is used again.
  void plan(const IterationContext& context, const GaussianFacts& facts, Plan& plan) const;
  /// The optimizer's step. In an iteration that is followed by a change of Gaussians no step is
  /// taken, as in the published code.
  StepOrder step(const IterationContext& context) const;

 private:
  /// The events between an iteration and the next.
  struct Events {
    bool change, final_prune, mask_prune, opacity_reset;
    bool change_the_set() const { return change || final_prune || mask_prune; }
  };
  Events events_after(const TrainSettings& settings, int iteration, const RunFacts& run) const;
  int end_in(const TrainSettings& settings) const {
    return follows_run ? settings.reduced_until() : end;
  }
};

std::span<const Strategy> strategies();
/// The strategy of `train` unless another is named.
const Strategy& default_strategy();

/// The strategy of this name. Throws Error(usage) if there is none.
const Strategy& find_strategy(std::string_view name);

void adc_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan);
void paced_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan);
void dash_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan);
void fastgs_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan);
void mcmc_change(const IterationContext& context, const GaussianFacts& facts, Plan& plan);
void paced_step(const IterationContext& context, StepOrder& order);
void fastgs_step(const IterationContext& context, StepOrder& order);
void mask_step(const IterationContext& context, StepOrder& order);
void mcmc_step(const IterationContext& context, StepOrder& order);
inline constexpr double kPacedGrowthEnd = 0.7;  ///< time of the run, see Pace
/// The number of Gaussians at the end of growth.
std::size_t paced_target(const TrainSettings& settings, const RunFacts& run);
bool paced_changes_after(const RunFacts& run, int iteration);
/// 70 for each training view, from 3,000 to 30,000.
int paced_iterations(std::size_t views);

}  // namespace qs::train
