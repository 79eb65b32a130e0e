// SPDX-License-Identifier: MIT
//
// The report of a training run: one row per interval, as train.csv and train.json hold it.
// train.json alone has the memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "learn/run/data_set.h"
#include "learn/run/trainer.h"

namespace qs::train {

struct LogRow {
  int iteration = 0;
  double seconds = 0;  ///< training time since the start, without evaluation and saving
  double loss = 0;     ///< mean since the row before
  std::size_t gaussians = 0;
  std::optional<Quality> test;
  std::optional<std::uint64_t> gpu_memory_bytes = std::nullopt;  ///< see TrainingModel
};

struct TrainLog {
  std::vector<LogRow> rows;
  double seconds = 0;
  double loss_sum = 0;  ///< since the last row
  int loss_count = 0;
  std::array<double, kTrainPasses.size()> stage_seconds = {};
  double evaluation_seconds = 0;  ///< not part of `seconds`
  std::vector<GuardRow> guard;    ///< all measurements
  std::string verdict;            ///< of the guard, see Guard::verdict()
  std::vector<Pace::Row> pace;    ///< the corrected pace of a run of given seconds; else empty

  /// Also adds the step's time to `seconds`.
  void add(const StepResult& step);
  /// Appends a row for the state and starts the next interval.
  void close_row(const Trainer& trainer, const std::optional<Quality>& test);
};

/// The row with the highest PSNR on the test views, the first of equal rows; nullptr if no row has
/// a PSNR.
const LogRow* best_row(const TrainLog& log);

/// The most memory of the GPU in any row; unset if no row has it.
std::optional<std::uint64_t> most_gpu_memory(const TrainLog& log);

/// "iteration,seconds,loss,gaussians,test_psnr,test_ssim" and the rows. If the guard has measured,
/// a column "reserved_psnr" has its last value since the row before.
std::string format_train_csv(const TrainLog& log);

/// The log as a JSON object, and back. log_of() throws nlohmann::json::exception.
nlohmann::ordered_json log_json(const TrainLog& log);
TrainLog log_of(const nlohmann::ordered_json& json);

// With few photographs, a model can get worse on the test views after some thousand iterations,
// because it fits the training views alone. A run notices that by evaluating the test views.

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
