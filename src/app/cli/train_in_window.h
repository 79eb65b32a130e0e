// SPDX-License-Identifier: MIT
//
// Connects a training run with the window that shows it.
#pragma once

#include "app/train/run.h"
#include "app/viewer/view_options.h"

namespace qs {

/// Trains beside the window, and returns when it is closed; then the model is saved. Throws Error.
void train_in_window(const train::TrainSettings& settings, const train::DataSet& data,
                     train::RunOptions options, ThreadPool& pool, ViewOptions view);

}  // namespace qs
