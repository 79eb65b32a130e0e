// SPDX-License-Identifier: MIT
//
// Ratios of times and their confidence intervals. Ratios are averaged as logarithms, so that
// swapping the two times gives exactly the inverse.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace qs {

struct Interval {
  double low = 0, high = 0;
};

struct Ratio {
  double value = 1;
  std::optional<Interval> interval;  ///< 95 % confidence; unset for fewer than two samples
  std::size_t samples = 0;
};

/// The factor of the two-sided 95 % interval of Student's t distribution, degrees >= 1.
double student_t95(std::size_t degrees);

/// The geometric mean of at least one positive ratio, with the Student t interval of the mean of
/// their logarithms.
Ratio geometric_mean(std::span<const double> ratios);

/// Half of the interval, which must exist: the larger of its two sides.
double half_interval(const Ratio& ratio);

/// True if the measurement does not show a faster mode, because the interval contains 1.
bool is_undecided(const Ratio& ratio);

/// "2.03x \u00b10.06" with half_interval(), "1.02x \u00b10.05 noisy" if is_undecided(), "2.03x"
/// without an interval.
std::string ratio_text(const Ratio& ratio);

}  // namespace qs
