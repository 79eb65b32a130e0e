// SPDX-License-Identifier: MIT
//
// Connects a training run with the window or the page that shows it.
#pragma once

#include <exception>
#include <string>

#include "app/viewer/render/training_thread.h"
#include "learn/run/train_options.h"

namespace qs {

class ShownRun {
 public:
  /// The arguments must outlive this object. The model of `prepared` is not yet trained.
  ShownRun(const train::TrainOptions& options, train::PreparedRun& prepared, ThreadPool& pool)
      : options_(options), prepared_(prepared), pool_(pool) {}

  /// Trains on the thread of the window, once; see TrainingThread::Work. Throws Error.
  std::string train(TrainingThread& thread);

  /// The end of train(), or its exception. `interrupted` if train() was not called.
  train::RunEnd end() const;

 private:
  const train::TrainOptions& options_;
  train::PreparedRun& prepared_;
  ThreadPool& pool_;
  train::RunEnd end_ = train::RunEnd::interrupted;
  std::exception_ptr error_;
};

/// The value of ViewOptions::train_request. It runs the command `train`, so cmd_train.cpp defines
/// it.
std::string train_request_in_window(TrainingThread& thread, const TrainingRequest& request);

}  // namespace qs
