// SPDX-License-Identifier: MIT
//
// Strategies: how the set of Gaussians changes while it is trained. To add one: a file with its
// function, declared here, a row in strategy.cpp and a test.
#pragma once

#include <span>
#include <string_view>

#include "app/train/model_state.h"
#include "app/train/settings.h"
#include "raster/base/parallel.h"

namespace qs::train {

/// A model in an iteration, which counts from 1.
struct ModelContext {
  const TrainSettings& settings;
  int iteration;
  double extent;  ///< world units, see DataSet::extent()
  const cpu::train::Rates& rates;
  ThreadPool& pool;
  ModelState& model;
};

/// An iteration after its backward pass.
struct StepContext : ModelContext {
  int width, height;  ///< of the frame
  Gradients& gradients;

  /// Adam's step with these gradients.
  void take_step() const;
};

struct Strategy {
  const char* name;
  const char* summary;
  double opacity_rate;                    ///< learning rate of opacity logits
  double initial_opacity, initial_scale;  ///< see InitialGaussians
  std::size_t default_max_gaussians;      ///< 0: no limit
  /// Adds and removes Gaussians when it is time. Called before the forward pass, so that the model
  /// is saved and evaluated before its Gaussians change, as in the published code.
  void (*prepare)(const ModelContext& context);
  /// Takes the optimizer's step. No step is taken in front of a change of Gaussians, as in the
  /// published code.
  void (*step)(const StepContext& context);

  std::size_t max_gaussians(const TrainSettings& settings) const {
    return settings.max_gaussians > 0 ? settings.max_gaussians : default_max_gaussians;
  }
};

std::span<const Strategy> strategies();

/// Throws Error(usage) for another name.
const Strategy& find_strategy(std::string_view name);

void adc_prepare(const ModelContext& context);
void adc_step(const StepContext& context);
void mcmc_prepare(const ModelContext& context);
void mcmc_step(const StepContext& context);

}  // namespace qs::train
