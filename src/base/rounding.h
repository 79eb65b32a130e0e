// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>

namespace qs {

/// `value` rounded and clamped to 0..`max`; NaN gives 0.
inline std::uint32_t round_to_integer(double value, std::uint32_t max) {
  return value > 0 ? static_cast<std::uint32_t>(std::min(value + 0.5, static_cast<double>(max)))
                   : 0;
}

}  // namespace qs
