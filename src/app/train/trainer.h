// SPDX-License-Identifier: MIT
//
// Trains a scene from photographs on the CPU, one iteration at a time. The result depends on the
// settings and the data only, not on the number of threads.
#pragma once

#include <array>
#include <optional>

#include "app/train/data_set.h"
#include "app/train/model_state.h"
#include "app/train/photograph_cache.h"
#include "app/train/schedule.h"
#include "app/train/settings.h"
#include "app/train/strategy.h"
#include "raster/cpu/train/backward.h"
#include "raster/cpu/train/loss.h"

namespace qs::train {

/// The parts of an iteration: adding and removing Gaussians, the passes, and the optimizer's step.
inline constexpr std::array kTrainStages = {"density", "forward", "loss", "backward", "optimizer"};

struct StepResult {
  cpu::train::Loss loss;                                 ///< before the step
  std::array<double, kTrainStages.size()> seconds = {};  ///< by stage
};

/// Means over the test views.
struct Quality {
  double psnr = 0, ssim = 0;
};

/// The Gaussians that a run starts from: the data set's points, or random ones.
Parameters starting_gaussians(const DataSet& data, const TrainSettings& settings, ThreadPool& pool);

class Trainer {
 public:
  /// `data` and `pool` must outlive the trainer. The model may be one that was saved.
  Trainer(const TrainSettings& settings, const DataSet& data, ModelState model, ThreadPool& pool);

  /// One iteration. Throws Error(input) when no Gaussian is left.
  StepResult step();

  /// Unset without test views.
  std::optional<Quality> test_quality();

  const ModelState& model() const { return model_; }
  GaussianCloud cloud() const;

 private:
  RenderSettings render_settings(int iteration) const;
  const PhotographView& view_of(int iteration);

  const TrainSettings settings_;
  const DataSet& data_;
  const Strategy& strategy_;
  const double extent_;
  ThreadPool& pool_;
  ModelState model_;
  ViewOrder views_;
  PhotographCache photographs_;

  cpu::train::ForwardFrame<float> frame_;
  cpu::train::BackwardScratch<float> backward_;
  cpu::train::LossScratch<float> loss_;
  std::vector<glm::vec3> d_color_;
  Gradients gradients_;
};

}  // namespace qs::train
