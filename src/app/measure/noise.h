// SPDX-License-Identifier: MIT
//
// Which rows of a benchmark should not be published, and why: their times drifted while they were
// measured, or the medians of their rounds differ.
#pragma once

#include <string>
#include <vector>

#include "app/measure/bench_row.h"

namespace qs {

inline constexpr double kNoiseTolerance = 0.03;  ///< of drift and of the rounds' medians

/// How far a row is from being at rest: the larger of its drift, without sign, and its
/// round_spread.
double noise(const BenchRow& row);

/// One sentence: how many rows are noisier than the tolerance, the worst of them and what it may
/// come from. Empty when none is.
std::string noise_sentence(const std::vector<BenchRow>& rows);

/// The same as a section of Markdown, with a table of the noisy rows; empty when there is none.
std::string noise_markdown(const std::vector<BenchRow>& rows);

}  // namespace qs
