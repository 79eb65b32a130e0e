// SPDX-License-Identifier: MIT
//
// With few photographs, a model can get worse on the test views after some thousand iterations,
// because it fits the training views alone. A run notices that by evaluating the test views.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "learn/run/data_set.h"
#include "learn/run/train_log.h"

namespace qs::train {

/// True if the best evaluation is kept by default: with fewer than 120 photographs, some of which
/// are test views.
bool keeps_best_by_default(const DataSet& data);

/// Iterations between evaluations, a multiple of 1,000, so that evaluations take at most about 3 %
/// of the time. It depends on the number of test views and on the backend, a TrainingModel::name(),
/// and not on measured times, so equal runs evaluate the same iterations.
int evaluation_interval(const DataSet& data, std::string_view backend);

/// If the test views have lost more than 0.2 dB since their best evaluation: a sentence with the
/// best iteration, and how to open it, or how to keep it if `folder`, the model's, does not have
/// it. "" otherwise.
std::string overfitting_sentence(const TrainLog& log, const std::filesystem::path& folder);

}  // namespace qs::train
