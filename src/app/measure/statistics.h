// SPDX-License-Identifier: MIT
//
// Statistics of frame times. Medians and percentiles interpolate linearly between the two nearest
// sorted values, so that they do not jump with the number of frames.
#pragma once

#include <optional>
#include <span>

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

/// Half of the distance between the quartiles; unset for fewer than two values.
std::optional<double> quartile_spread(std::span<const double> values);

/// Largest minus smallest value, divided by the median; 0 for fewer than two values.
double relative_spread(std::span<const double> values);

}  // namespace qs
