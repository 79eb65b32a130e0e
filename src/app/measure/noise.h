// SPDX-License-Identifier: MIT
//
// Finds rows of a benchmark that are too noisy to publish: their times drifted during the
// measurement, or the medians of their rounds differ.
#pragma once

#include <string>
#include <vector>

#include "app/measure/bench_row.h"

namespace qs {

inline constexpr double kNoiseTolerance = 0.03;  ///< largest acceptable noise()

/// The larger of the row's absolute drift and its round_spread, if it has one.
double noise(const BenchRow& row);

/// One sentence: the number of noisy rows, the noisiest row and its likely cause. Empty if no row
/// is noisy.
std::string noise_sentence(const std::vector<BenchRow>& rows);

/// The same as a Markdown section with a table of the noisy rows; empty if no row is noisy.
std::string noise_markdown(const std::vector<BenchRow>& rows);

}  // namespace qs
