// SPDX-License-Identifier: MIT
//
// The text of measured numbers, the same in the window, in reports and in the tables of commands: a
// number has the digits that its spread leaves significant.
#pragma once

#include <optional>
#include <string>

#include "app/measure/bench_row.h"
#include "raster/api/renderer.h"

namespace qs {

/// The value with the digits that its uncertainty leaves significant, at most three decimals:
/// 12.3456 with 0.04 is "12.35", 1234 with 40 is "1230".
std::string significant(double value, double uncertainty);

/// Milliseconds with three decimals; FPS with one below 1000.
std::string ms_text(double ms);
std::string fps_text(double fps);

/// A median and half of the distance between the quartiles: "12.35 \u00b10.04". ms_text() without a
/// spread.
std::string time_text(double ms, std::optional<double> spread_ms);

/// False if `bin` is part of other stages, see is_timed(); then bin_ms is 0.
bool times_bin(const BenchRow& row);

/// The time of a stage, "0.123 ms", or the stages that it is part of, see is_timed().
std::string stage_text(const BenchRow& row, Stage stage);

/// The FPS of a median of `ms`, with the digits that `spread_ms` leaves.
std::string rate_text(double ms, std::optional<double> spread_ms);

}  // namespace qs
