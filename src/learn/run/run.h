// SPDX-License-Identifier: MIT
//
// A whole training run: from a data set to a model folder, with progress, evaluation, saving and
// interruption.
#pragma once

#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include <fmt/format.h>

#include "base/training_command.h"
#include "base/warn.h"
#include "learn/run/data_set.h"
#include "learn/run/model_folder.h"
#include "learn/step/training_model.h"

namespace qs::train {

/// The text of a run for its user: sentences without a line break.
struct RunText {
  using Say = std::function<void(const std::string& sentence)>;

  /// The backend, an evaluation, the saved model.
  Say result = [](const std::string& sentence) {
    fmt::print("{}\n", sentence);
    std::fflush(stdout);
  };
  /// About the model folder.
  Say note = [](const std::string& sentence) { fmt::print(stderr, "{}\n", sentence); };
  Say warning = [](const std::string& sentence) { warn(sentence); };
  bool has_bars = true;  ///< progress bars, if stderr is a terminal
};

class Trainer;
struct TrainLog;

/// The state of a run, for its watcher.
struct RunStatus {
  const Trainer& trainer;
  const TrainLog& log;
  double loss;  ///< the loss of the last iteration; 0 before the first
};

struct RunOptions {
  std::filesystem::path out_dir;
  /// iterations; 0: evaluation_interval() if the best evaluation is kept, else only at the end
  int eval_every = 0;
  int save_every = 0;  ///< iterations; 0: only at the end
  /// also saves the Gaussians of the best evaluation; unset: keeps_best_by_default()
  std::optional<bool> keep_best;
  bool resume = false;
  bool keep_checkpoint = false;  ///< a finished run keeps its checkpoint, which otherwise goes
  /// out_dir may hold files; else it is new or empty, or `resume` is true. Without `resume`,
  /// remove_old_iterations() of it.
  bool overwrite = false;
  std::optional<Parameters> initial;  ///< unset: from the data set's points
  /// Called before the first iteration, after every iteration, and after the last evaluation. It is
  /// called again after it returned `save`, and returns `go_on` or `stop` else. A watched run does
  /// not handle signals.
  std::function<TrainingCommand(const RunStatus&)> watch;
  /// Requests that the run ends early, also during an evaluation.
  std::stop_token stop;
  RunText text;
  /// Writes the course of the run as a page into the folder. Returns a warning, or "". Unset: none.
  std::function<std::string(const std::filesystem::path& folder, const TrainSettings& settings,
                            const TrainLog& log)>
      write_page;
};

enum class RunEnd { finished, interrupted };

/// `model` is new; its backend trains. Trains until the end of the pace, or until a signal arrives
/// (quit_signals.h) or the run is stopped, and saves the model in all cases. Throws Error. If
/// memory or a device is lacking, the model is first saved if possible.
RunEnd run_training(const TrainSettings& settings, const DataSet& data, const RunOptions& options,
                    std::unique_ptr<TrainingModel> model, ThreadPool& pool);

}  // namespace qs::train
