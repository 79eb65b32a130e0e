// SPDX-License-Identifier: MIT
//
// The plots of a zoom: FPS, milliseconds and pairs against the zoom, one curve per mode. Times have
// a band of 5-95 % of the frames, if there are enough frames for one.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/report/plot.h"
#include "app/report/zoom_bundle.h"

namespace qs {

inline constexpr std::uint64_t kFewestBandFrames =
    5;  ///< a point with fewer frames has no band of 5-95 %

/// The smallest number of frames behind a row; 0 if it is unknown or there are no rows.
std::uint64_t frames_per_point(const std::vector<BenchRow>& rows);

/// True if every row has at least kFewestBandFrames frames. False without rows.
bool has_bands(const std::vector<BenchRow>& rows);

/// The zoom of a row: first distance to the target / distance, >= 1. `steps` >= 2.
double zoom_factor(const BenchRow& row, int steps, double closest);

/// A mark of an axis.
struct AxisTick {
  double value;
  std::string text;
};

/// The ticks of the zoom's axis, which is logarithmic from 1 to `most` > 1: 1x, 2x, 5x, 10x, 20x.
/// An axis that ends below 2 has ticks at round distances: 1x, 1.05x, 1.1x.
std::vector<AxisTick> zoom_ticks(double most);

/// At least two ticks of an axis from 0: round numbers, 1, 2 or 5 times a power of ten apart. The
/// last tick is the first that is not below `most` > 0.
std::vector<AxisTick> round_ticks(double most);

std::vector<Plot> zoom_plots(const ZoomBundle& bundle);

}  // namespace qs
