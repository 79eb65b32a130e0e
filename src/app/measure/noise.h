// SPDX-License-Identifier: MIT
//
// Finds rows of a benchmark that are too noisy to publish: their frames differ, their times drifted
// during the measurement, or the medians of their rounds differ. A zoom has few frames per row, so
// its curves have a rule of their own.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/measure/bench_row.h"

namespace qs {

inline constexpr double kNoiseTolerance = 0.03;  ///< largest acceptable noise()
inline constexpr double kNoisySpread = 0.1;      ///< largest acceptable spread_ms(), of the median

/// The larger of the row's absolute drift and its round_spread, if it has one.
double noise(const BenchRow& row);

/// BenchRow::ms_spread; from the rounds if it is unset. Unset for one frame.
std::optional<double> spread_ms(const BenchRow& row);

/// True if the spread is above kNoisySpread.
inline bool is_noisy_spread(std::optional<double> spread_ms, double median_ms) {
  return spread_ms && *spread_ms > kNoisySpread * median_ms;
}

/// True if the spread of the row is above kNoisySpread.
bool has_noisy_time(const BenchRow& row);

/// True if has_noisy_time() or if noise() is above its tolerance.
bool is_noisy(const BenchRow& row);

/// One sentence: the number of noisy rows, the noisiest row and its likely cause. Empty if no row
/// is noisy.
std::string noise_sentence(const std::vector<BenchRow>& rows);

/// noise_sentence() as a Markdown section with a table of the noisy rows; empty if no row is noisy.
std::string noise_markdown(const std::vector<BenchRow>& rows);

/// The number of noisy steps per mode of a zoom: "3dgs 2, exact 1 of 12". Empty if no point is
/// noisy. A step is noisy if its row has at least two frames, and half of the distance between
/// their quartiles, or their drift, exceeds a tenth of the median.
std::string noisy_steps(const std::vector<BenchRow>& rows);

}  // namespace qs
