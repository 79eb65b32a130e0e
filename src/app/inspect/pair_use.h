// SPDX-License-Identifier: MIT
//
// Classifies pairs (a Gaussian listed in a tile). A pair that no pixel blends is a false positive:
// either empty, because alpha reaches 1/255 at no pixel centre of the tile, and a tighter bound
// would avoid it; or hidden, because all pixels that it reaches have stopped before it. No bound
// can detect hidden pairs. So mode `exact` has false positives too.
#pragma once

#include <stop_token>
#include <vector>

#include "app/inspect/pixel.h"
#include "base/parallel.h"

namespace qs {

/// From best to worst.
enum class PairUse : std::uint8_t {
  used,    ///< a pixel blends it
  hidden,  ///< alpha reaches 1/255, but only at pixels that have stopped
  empty,   ///< alpha reaches 1/255 at no pixel
};

struct PairUses {
  std::uint64_t used = 0, hidden = 0, empty = 0;
  std::uint64_t false_positives() const { return hidden + empty; }
  std::uint64_t pairs() const { return used + hidden + empty; }
};

/// The use of every pair, parallel to Trace::listed. `size`: of the image. Throws Cancelled.
std::vector<PairUse> pair_uses(const Frame& frame, glm::ivec2 size, ThreadPool& pool,
                               std::stop_token stop = {});

PairUses sum_up(const std::vector<PairUse>& uses);

/// The use of a pair of the Gaussian in `slot` of the trace and a tile. The tile need not list the
/// Gaussian.
PairUse use_in_tile(const Frame& frame, glm::ivec2 size, std::size_t slot, int tile);

}  // namespace qs
