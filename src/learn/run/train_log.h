// SPDX-License-Identifier: MIT
//
// The report of a training run: one row per interval, as train.csv and train.json hold it.
// train.json alone has the memory.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

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

/// "iteration,seconds,loss,gaussians,test_psnr,test_ssim" and the rows.
std::string format_train_csv(const TrainLog& log);

/// The log as a JSON object, and back. log_of() throws nlohmann::json::exception.
nlohmann::ordered_json log_json(const TrainLog& log);
TrainLog log_of(const nlohmann::ordered_json& json);

}  // namespace qs::train
