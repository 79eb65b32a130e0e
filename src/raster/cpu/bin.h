// SPDX-License-Identifier: MIT
//
// Stage 3 of the CPU backend: every visible Gaussian into the lists of the tiles that the mode
// gives it.
#pragma once

#include "raster/cpu/sort.h"

namespace qs::cpu {

struct TileLists {
  std::vector<std::uint64_t> begin;  ///< tiles + 1 offsets into `slots`
  Array<std::uint32_t> slots;        ///< slots of Visible, per tile front to back

  std::uint64_t pairs() const { return begin.empty() ? 0 : begin.back(); }
  std::uint32_t pairs(std::size_t tile) const {
    return static_cast<std::uint32_t>(begin[tile + 1] - begin[tile]);
  }

  std::vector<std::uint64_t> cursors;  ///< scratch
};

/// Throws Error(device) when the lists do not fit into memory.
void bin(const FrameContext& frame, const Visible& visible, const DepthOrder& order,
         TileLists& lists);

}  // namespace qs::cpu
