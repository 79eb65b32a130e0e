// SPDX-License-Identifier: MIT
//
// A scale with round numbers for counts that start at 0.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace qs {

struct Scale {
  std::uint32_t step = 1;                    ///< 1, 2 or 5 times a power of ten
  std::uint32_t maximum = 1;                 ///< a multiple of step
  std::vector<std::uint32_t> ticks() const;  ///< 0, step, ..., maximum
};

/// The scale that reaches `maximum` in four to eight steps (fewer below 4).
Scale round_scale(std::uint32_t maximum);

/// round_scale() of the 99.5th percentile: a few extreme values do not darken all others.
Scale scale_for(std::span<const std::uint32_t> values);

/// The same for values with signs: it reaches from -maximum to maximum.
Scale scale_for_signed(std::span<const std::int32_t> values);

}  // namespace qs
