// SPDX-License-Identifier: MIT
//
// Values by their rank in order: medians and quantiles.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace qs {

/// The value with `rank` values before it in order. Reorders `values`, which are more than `rank`.
template <class T>
T at_rank(std::vector<T>& values, std::size_t rank) {
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

/// The value at the fraction 0..1 of the order. Reorders `values`, which are not empty.
template <class T>
T quantile(std::vector<T>& values, double fraction) {
  const double rank = fraction * static_cast<double>(values.size() - 1);
  return at_rank(values, static_cast<std::size_t>(std::lround(rank)));
}

/// The upper one of two medians. `values` is not empty.
template <class T>
T upper_median(std::vector<T> values) {
  return at_rank(values, values.size() / 2);
}

}  // namespace qs
