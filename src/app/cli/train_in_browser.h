// SPDX-License-Identifier: MIT
//
// Connects a training run with the page that shows it.
#pragma once

#include <memory>

#include "app/serve/served_training.h"
#include "app/serve/server.h"
#include "learn/run/run.h"

namespace qs {

/// Trains `model`, which is new, while `server` shows it, and returns after the run has ended.
/// `interrupted`: by a signal. `serve`: the server's options. Throws Error.
train::RunEnd train_in_browser(const train::TrainSettings& settings, const train::DataSet& data,
                               train::RunOptions options,
                               std::unique_ptr<train::TrainingModel> model, ThreadPool& pool,
                               Server& server, const ServeOptions& serve, const PageFacts& page);

}  // namespace qs
