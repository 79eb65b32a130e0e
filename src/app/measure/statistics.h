// SPDX-License-Identifier: MIT
//
// What a list of frame times comes down to. Medians and percentiles interpolate linearly between
// the two nearest of the sorted values, so that they do not jump with the number of frames.
#pragma once

#include <span>

namespace qs {

/// All in the unit of the values; an empty list gives zeros.
struct Summary {
  double median = 0, p05 = 0, p95 = 0, mean = 0;
  double drift = 0;  ///< median of the later half over that of the earlier half, minus 1
};

/// Of at least one value; `fraction` is 0..1.
double percentile(std::span<const double> values, double fraction);

inline double median(std::span<const double> values) { return percentile(values, 0.5); }

/// `values` in the order they were measured.
Summary summarise(std::span<const double> values);

/// Largest minus smallest value over the median; 0 for fewer than two.
double relative_spread(std::span<const double> values);

}  // namespace qs
