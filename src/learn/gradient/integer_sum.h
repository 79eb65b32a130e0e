// SPDX-License-Identifier: MIT
//
// Sums of derivatives that do not depend on the order of the additions: they are integers, in units
// of 2^-40.
#pragma once

#include <cmath>
#include <cstdint>

#include "raster/kernel/hd.h"

namespace qs {

inline constexpr double kSumUnit = 0x1p-40;

/// The nearest integer, of two equally near ones that farther from 0, as by std::round, which takes
/// many more instructions on a GPU. All steps are exact.
template <class Real>
QS_HD Real rounded(Real value) {
  const Real whole = std::trunc(value), rest = value - whole;
  if (rest >= Real(0.5)) return whole + 1;
  return rest <= Real(-0.5) ? whole - 1 : whole;
}

/// The value in units of the sums. A value that is not finite counts as 0, and others are limited
/// to 2^20.
template <class Real>
QS_HD std::int64_t sum_units(Real value) {
  constexpr Real kLargest = 0x1p20, kUnits = 0x1p40;
  if (!(value - value == 0)) return 0;
  if (value > kLargest) value = kLargest;
  if (value < -kLargest) value = -kLargest;
  return static_cast<std::int64_t>(rounded(value * kUnits));
}

}  // namespace qs
