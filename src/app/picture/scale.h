// SPDX-License-Identifier: MIT
//
// Round numbers: steps, and scales from 0 to a maximum.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace qs {

/// The first of 1, 2 and 5 times powers of ten for which fits(step), from the power at or below
/// `from` on, which is > 0.
template <class Fits>
double round_step(double from, const Fits& fits) {
  for (double power = std::pow(10.0, std::floor(std::log10(from)));; power *= 10) {
    for (const double step : {power, 2 * power, 5 * power})
      if (fits(step)) return step;
  }
}

struct Scale {
  std::uint32_t step = 1;                    ///< 1, 2 or 5 times a power of ten
  std::uint32_t maximum = 1;                 ///< the end of the scale, at least 1
  std::vector<std::uint32_t> ticks() const;  ///< 0, step, ..., maximum
  bool operator==(const Scale&) const = default;
};

/// A scale up to at least `maximum` in four to eight steps (fewer below 4).
Scale round_scale(std::uint32_t maximum);

/// The scale up to exactly `maximum`, with the steps of round_scale(). 0 is drawn as 1.
Scale exact_scale(std::uint32_t maximum);

/// round_scale() of the 99.5th percentile, so that a few extreme values do not darken all others.
Scale scale_for(std::span<const std::uint32_t> values);

/// scale_for() the absolute values; the scale is used from -maximum to maximum.
Scale scale_for_signed(std::span<const std::int32_t> values);

}  // namespace qs
