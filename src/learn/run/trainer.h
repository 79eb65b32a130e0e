// SPDX-License-Identifier: MIT
//
// Trains a scene from photographs, one iteration at a time, with the model in the memory of a
// backend. The result depends on the settings, the data and the backend only, not on the number of
// threads.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/progress.h"
#include "learn/run/data_set.h"
#include "learn/run/guard.h"
#include "learn/run/photograph_cache.h"
#include "learn/run/schedule.h"
#include "learn/run/settings.h"
#include "learn/run/strategy.h"
#include "learn/step/training_model.h"

namespace qs::train {

/// The parts of an iteration: adding and removing Gaussians, the passes, the optimizer's step, and
/// the remainder: on a GPU, the time in which the GPU waits for the host.
inline constexpr std::array kTrainPasses = {"density",  "forward",   "loss",
                                            "backward", "optimizer", "other"};

struct StepResult {
  Loss loss;  ///< before the step; on CUDA usually of the previous step, see recent_loss()
  /// By stage; together the time of the step. On CUDA the passes' times are from the previous step,
  /// on the GPU's clock.
  std::array<double, kTrainPasses.size()> seconds = {};
};

RunFacts run_facts_of(const DataSet& data, const Pace& pace);

/// The Gaussians that a run starts from: the data set's points, or random points; without masks.
Parameters starting_gaussians(const DataSet& data, const TrainSettings& settings, ThreadPool& pool);

class Trainer {
 public:
  /// `model` holds the state to start from, and `measured` the guard's measurements until then.
  /// `pace` is empty, or a corrected pace that replaces the settings' pace.
  /// `data` and `pool` must outlive the trainer.
  Trainer(const TrainSettings& settings, const DataSet& data, std::unique_ptr<TrainingModel> model,
          ThreadPool& pool, std::vector<GuardRow> measured = {}, std::vector<Pace::Row> pace = {});

  /// Computes the resolution schedule, if the settings ask for one and it was not computed before.
  /// Throws Error(input) and Cancelled. step() calls it too.
  void prepare(const Progress& progress = {});

  /// One iteration. Throws Error(input) when no Gaussian is left.
  StepResult step();

  /// Means over the test views. Unset without test views.
  std::optional<Quality> test_quality(const Progress& progress = {});

  int iteration() const { return model_->iteration(); }  ///< the iteration of the last step
  std::size_t gaussians() const { return model_->size(); }
  /// The Gaussians that are not masked out, as files have them. On CUDA this may copy the model.
  std::size_t existing_gaussians() const {
    return strategy_.has_masks ? count_existing(model_->parameters()) : model_->size();
  }
  std::optional<std::uint64_t> gpu_memory_bytes() const { return model_->gpu_memory_bytes(); }
  const Guard& guard() const { return guard_; }
  /// The number of iterations of the run, at the current pace.
  int last_iteration() const { return run_.pace.end(); }
  const Pace& pace() const { return run_.pace; }
  /// Corrects the pace after `elapsed` seconds.
  void correct_pace(double elapsed, PaceControl& control);
  /// A reference to the model or to a copy of it, until the next call.
  const ModelState& model() const { return model_->state(); }
  /// The Gaussians as renderers have them. On CUDA this copies them from the GPU.
  GaussianCloud cloud() const;

 private:
  RenderSettings render_settings(int iteration) const;
  StepOrder step_order(const IterationContext& context) const;
  const PhotographView& view_of(int iteration);
  IterationContext context_of(int iteration) const;
  std::optional<std::size_t> number_of(std::size_t view) const;
  std::size_t view_at(int iteration);
  void count_errors(int iteration, int views);
  void forward(const PhotographView& view, const RenderSettings& render);
  /// Means over views of the data set.
  Quality mean_quality(std::span<const PhotographView* const> views, const Progress& progress = {});
  void measure_if_due();
  void require_codes();  ///< draws the codes of shapes if the model has none

  const TrainSettings settings_;
  const DataSet& data_;
  const Strategy& strategy_;
  const double extent_;
  ThreadPool& pool_;
  std::unique_ptr<TrainingModel> model_;
  RunFacts run_;
  Guard guard_;
  ViewOrder views_, trained_views_;  ///< all, and without the reserved ones
  PhotographCache photographs_;
  ReducedPhotographs reduced_;
  std::optional<ResolutionSchedule> schedule_;  ///< set by prepare()
  Plan plan_;                                   ///< the plan of the last change
  bool has_codes_ = false;                      ///< the model is known to have codes of shapes
};

}  // namespace qs::train
