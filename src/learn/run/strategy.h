// SPDX-License-Identifier: MIT
//
// A strategy changes the set of Gaussians while it is trained. It decides on the host, from a few
// numbers per Gaussian, so every backend supports all strategies. To add a strategy: a file with
// its functions, declared here, a row in strategy.cpp and a test.
#pragma once

#include <span>
#include <string_view>

#include "learn/run/settings.h"
#include "learn/step/training_model.h"

namespace qs::train {

/// An iteration, which counts from 1.
struct IterationContext {
  const TrainSettings& settings;
  int iteration;
  double extent;  ///< world units, see DataSet::extent()
  Rates rates;
  int last_factor = 1;  ///< by which the photograph of the iteration before was reduced

  /// Adam's step with these rates.
  StepOrder step() const {
    StepOrder order;
    order.iteration = iteration;
    order.rates = rates;
    return order;
  }
};

struct Strategy {
  const char* name;
  const char* summary;
  double opacity_rate;                    ///< learning rate of opacity logits
  double initial_opacity, initial_scale;  ///< see InitialGaussians
  std::size_t default_max_gaussians;      ///< 0: no limit
  /// True if the plan changes the set of Gaussians before the iteration starts. The model is saved
  /// and evaluated before the change, as in the published code.
  bool (*changes_before)(const TrainSettings& settings, int iteration);
  /// Sets `plan`. Its memory is used again.
  void (*plan)(const IterationContext& context, const GaussianFacts& facts, Plan& plan);
  /// The optimizer's step. In an iteration that is followed by a change of Gaussians no step is
  /// taken, as in the published code.
  StepOrder (*step)(const IterationContext& context);
  /// True if the density statistics need absolute gradients.
  bool (*absolute_gradients)(const TrainSettings& settings) = [](const TrainSettings&) {
    return false;
  };
  /// The number of training views whose pixels are counted for GaussianFacts::counts before the
  /// plan for this iteration; 0: none.
  int (*scored_views)(const TrainSettings& settings, int iteration) = [](const TrainSettings&,
                                                                         int) { return 0; };

  /// True if training begins with reduced photographs unless the user chose otherwise, and the rate
  /// of the means falls from ResolutionSchedule::details_from().
  bool reduces_photographs = false;
  /// True if every Gaussian has a mask that is trained, see kernel/gradient/mask.h.
  bool has_masks = false;

  std::size_t max_gaussians(const TrainSettings& settings) const {
    return settings.max_gaussians > 0 ? settings.max_gaussians : default_max_gaussians;
  }
};

std::span<const Strategy> strategies();

/// The strategy of this name. Throws Error(usage) if there is none.
const Strategy& find_strategy(std::string_view name);

bool adc_absolute_gradients(const TrainSettings& settings);
bool adc_changes_before(const TrainSettings& settings, int iteration);
void adc_plan(const IterationContext& context, const GaussianFacts& facts, Plan& plan);
StepOrder adc_step(const IterationContext& context);
bool dash_changes_before(const TrainSettings& settings, int iteration);
void dash_plan(const IterationContext& context, const GaussianFacts& facts, Plan& plan);
StepOrder dash_step(const IterationContext& context);
bool fastgs_absolute_gradients(const TrainSettings& settings);
bool fastgs_changes_before(const TrainSettings& settings, int iteration);
int fastgs_scored_views(const TrainSettings& settings, int iteration);
void fastgs_plan(const IterationContext& context, const GaussianFacts& facts, Plan& plan);
StepOrder fastgs_step(const IterationContext& context);
bool mask_changes_before(const TrainSettings& settings, int iteration);
void mask_plan(const IterationContext& context, const GaussianFacts& facts, Plan& plan);
StepOrder mask_step(const IterationContext& context);
bool mcmc_changes_before(const TrainSettings& settings, int iteration);
void mcmc_plan(const IterationContext& context, const GaussianFacts& facts, Plan& plan);
StepOrder mcmc_step(const IterationContext& context);

}  // namespace qs::train
