// SPDX-License-Identifier: MIT
//
// Connects a training run with the window that shows it.
#pragma once

#include <memory>
#include <string>

#include "app/viewer/view_options.h"
#include "learn/run/run.h"

namespace qs {

/// Trains `model`, which is new, beside the window, and returns after the window was closed and the
/// model was saved. `interrupted`: the window was closed, or the run stopped in it, before the last
/// iteration. Throws Error.
train::RunEnd train_in_window(const train::TrainSettings& settings, const train::DataSet& data,
                              train::RunOptions options,
                              std::unique_ptr<train::TrainingModel> model, ThreadPool& pool,
                              ViewOptions view);

/// Trains `model`, which is new, on the thread of the window. Throws Error.
train::RunEnd train_beside_window(TrainingThread& thread, const train::TrainSettings& settings,
                                  const train::DataSet& data, train::RunOptions options,
                                  std::unique_ptr<train::TrainingModel> model, ThreadPool& pool);

/// The window's sentence about a run that ended.
std::string sentence_of(train::RunEnd end);

/// ViewOptions::train_request.
std::string train_request_in_window(TrainingThread& thread, const TrainingRequest& request);

}  // namespace qs
