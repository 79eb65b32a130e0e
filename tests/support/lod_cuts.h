// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "learn/lod/cut.h"
#include "support/pool.h"

namespace qs::test {

/// The best cut of a whole tree by given gains, see qs::choose_cut().
inline std::vector<std::uint32_t> choose_cut(const RadLevels& levels, const LodGains& gains,
                                             std::size_t budget) {
  return qs::choose_cut(levels, gains, budget, pool());
}

}  // namespace qs::test
