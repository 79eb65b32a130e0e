// SPDX-License-Identifier: MIT
//
// A whole training run: from a data set to a model folder, with progress, evaluation, saving and
// interruption.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "app/train/checkpoint.h"
#include "app/train/data_set.h"
#include "raster/api/training_model.h"

namespace qs::train {

class Trainer;
struct TrainLog;

/// What a run shows to its watcher.
struct RunStatus {
  const Trainer& trainer;
  const TrainLog& log;
  double loss;  ///< of the last iteration; 0 before the first
};

enum class RunWish { go_on, save, stop };

struct RunOptions {
  std::filesystem::path out_dir;
  int eval_every = 0;      ///< iterations; 0: only at the end
  int save_every = 0;      ///< iterations; 0: only at the end
  bool keep_best = false;  ///< also saves the Gaussians of the best evaluation
  bool resume = false;
  std::optional<Parameters> initial;  ///< unset: from the data set's points
  /// Called before the first iteration, after every one, and after the last evaluation. After
  /// `save` it is called again. A watched run notes no signals.
  std::function<RunWish(const RunStatus&)> watch;
};

enum class RunEnd { finished, interrupted };

/// `model` is new; its backend trains. Trains until settings.iterations, or until a signal arrives
/// (quit_signals.h), and saves the model in both cases. Prints the backend, one line per evaluation
/// and one for the saved model to stdout. Throws Error; one for lack of memory or of a device is
/// thrown after the model was saved, if that succeeded.
RunEnd run_training(const TrainSettings& settings, const DataSet& data, const RunOptions& options,
                    std::unique_ptr<TrainingModel> model, ThreadPool& pool);

}  // namespace qs::train
