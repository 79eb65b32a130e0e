// SPDX-License-Identifier: MIT
//
// The options of a training run, as `quadsplat train`, the window and libquadsplat have them, and
// the start of a run with them.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "learn/run/run.h"
#include "options/option_table.h"

namespace qs::train {

struct TrainOptions {
  DataOptions data;
  TrainSettings settings;
  RunOptions run;
  std::optional<bool> many_gaussians, dash_of_paper;  ///< unset: not given
  bool keep_best = false, keep_last = false;
  std::optional<bool> reduces_photographs;  ///< unset: as the strategy does
  std::optional<std::filesystem::path> init;
  int max_gaussians = 0, random_points = 100'000;
  std::optional<int> gaussians;               ///< the number that `paced` reaches
  std::optional<int> iterations;              ///< unset: as in `settings`
  std::optional<std::filesystem::path> pace;  ///< train.json of a run of given seconds
};

/// The names of the data set and of the model folder in the table.
inline constexpr const char* kDataOption = "DATA";
inline constexpr const char* kModelOption = "--out-dir";

/// All options except for the backend and the window. The table refers to `options`.
void declare_train_options(OptionTable& table, TrainOptions& options);

/// The inputs of run_training().
struct PreparedRun {
  std::unique_ptr<TrainingModel> model;
  DataSet data;
};

/// Checks the options, which it completes, and reads the data set. Throws Error and Cancelled.
PreparedRun prepare(TrainOptions& options, Backend backend, int device, ThreadPool& pool,
                    const Progress& progress);

}  // namespace qs::train
