// SPDX-License-Identifier: MIT
//
// Statistics of frame times, and their text, the same in the window, in reports and in the tables
// of commands: a number has the digits that its spread leaves significant. Medians and percentiles
// interpolate linearly between the two nearest sorted values, so that they do not jump with the
// number of frames.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/measure/bench_row.h"
#include "raster/api/renderer.h"

namespace qs {

/// All in the unit of the values; an empty list gives zeros.
struct Summary {
  double median = 0, p05 = 0, p95 = 0, mean = 0;
  double drift = 0;  ///< median of the later half / median of the earlier half, minus 1
};

/// The percentile at `fraction` (0..1) of at least one value.
double percentile(std::span<const double> values, double fraction);

inline double median(std::span<const double> values) { return percentile(values, 0.5); }

/// `values` are in the order of measurement.
Summary summarise(std::span<const double> values);

/// Spearman's rank correlation of two lists of one length, -1..1; equal values share their mean
/// rank. Unset if all values of a list are equal.
std::optional<double> rank_correlation(std::span<const double> a, std::span<const double> b);

/// Half of the distance between the quartiles; unset for fewer than two values.
std::optional<double> quartile_spread(std::span<const double> values);

/// Sets the row's frames and the numbers of their times.
void set_times(BenchRow& row, std::span<const double> frame_ms);

/// Largest minus smallest value, divided by the median; 0 for fewer than two values.
double relative_spread(std::span<const double> values);

/// The value with the digits that its uncertainty leaves significant, at most three decimals:
/// 12.3456 with 0.04 is "12.35", 1234 with 40 is "1230".
std::string significant(double value, double uncertainty);

/// Two significant digits, because single frames give no more: 312.5 is 310, "310"; 0.834 is
/// "0.83". 0 for values that are not positive.
double rounded(double value);
std::string rough(double value);

/// Milliseconds with three decimals; FPS with one below 1000.
std::string ms_text(double ms);
std::string fps_text(double fps);

/// Three significant digits, at most three decimals: 20.251 is "20.3".
std::string three_digits(double value);

/// A median and half of the distance between the quartiles: "12.35 \u00b10.04". ms_text() without a
/// spread.
std::string time_text(double ms, std::optional<double> spread_ms);

/// False if `bin` is part of other stages, see is_timed(); then bin_ms is 0.
bool times_bin(const BenchRow& row);

/// The time of a stage, "0.123 ms", or the stages that it is part of, see is_timed().
std::string stage_text(const BenchRow& row, Stage stage);

/// The FPS of a median of `ms`, with the digits that `spread_ms` leaves.
std::string rate_text(double ms, std::optional<double> spread_ms);

// Finds rows of a benchmark that are too noisy to publish: their frames differ, their times drifted
// during the measurement, or the medians of their rounds differ. A zoom has few frames per row, so
// its curves have a rule of their own.

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

/// True for a row of a zoom with at least two frames if half of the distance between their
/// quartiles, or their drift, exceeds a tenth of the median.
bool is_noisy_step(const BenchRow& row);

/// The number of noisy steps per mode of a zoom: "3dgs 2, exact 1 of 12". Empty if no step is
/// noisy.
std::string noisy_steps(const std::vector<BenchRow>& rows);

}  // namespace qs
