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
  std::optional<Interval> interval;  ///< of 95 % confidence; unset for fewer than two samples
  std::size_t samples = 0;
};

/// The factor of the two-sided 95 % interval of Student's t distribution, degrees >= 1.
double student_t95(std::size_t degrees);

/// The geometric mean of at least one positive ratio, with the Student t interval of the mean of
/// their logarithms.
Ratio geometric_mean(std::span<const double> ratios);

/// "2.03x [1.98, 2.09]", or "2.03x" without an interval.
std::string ratio_text(const Ratio& ratio);

}  // namespace qs
