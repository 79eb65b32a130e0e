// SPDX-License-Identifier: MIT
//
// What became of a pair, a Gaussian listed in a tile. Pairs that no pixel used are false positives,
// and there are two reasons for them: the Gaussian does not reach 1/255 at any pixel centre of the
// tile, which a better shape avoids, or every pixel that it reaches had stopped in front of it,
// which no shape can know. The second is why mode `exact` has false positives too.
#pragma once

#include <stop_token>
#include <vector>

#include "app/inspect/pixel.h"
#include "raster/base/parallel.h"

namespace qs {

/// In this order a pair is good to bad.
enum class PairUse : std::uint8_t {
  used,    ///< a pixel blends it
  hidden,  ///< alpha reaches 1/255 at a pixel, but only where they have stopped
  empty,   ///< it reaches no pixel
};
inline constexpr const char* kPairUseNames[] = {"used", "hidden", "empty"};

struct PairUses {
  std::uint64_t used = 0, hidden = 0, empty = 0;
  std::uint64_t false_positives() const { return hidden + empty; }
  std::uint64_t pairs() const { return used + hidden + empty; }
};

/// Of every pair, parallel to Trace::listed. `size`: of the image. Throws Cancelled.
std::vector<PairUse> pair_uses(const Frame& frame, glm::ivec2 size, ThreadPool& pool,
                               std::stop_token stop = {});

PairUses sum_up(const std::vector<PairUse>& uses);

/// Of the Gaussian in `slot` of the trace in any tile, listed there or not: what it would become
/// among the Gaussians that are.
PairUse use_in_tile(const Frame& frame, glm::ivec2 size, std::size_t slot, int tile);

}  // namespace qs
