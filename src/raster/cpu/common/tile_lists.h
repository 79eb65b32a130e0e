// SPDX-License-Identifier: MIT
//
// The tile lists: output of bin and input of blend, in both pipelines.
#pragma once

#include <cstdint>

#include "raster/cpu/common/frame_context.h"

namespace qs::cpu {

struct TileLists {
  std::vector<std::uint64_t> begin;  ///< tiles + 1 offsets into `slots`
  Array<std::uint32_t> slots;        ///< slots of VisibleSlots, per tile front to back

  std::uint64_t pairs() const { return begin.empty() ? 0 : begin.back(); }
  std::uint32_t pairs(std::size_t tile) const {
    return static_cast<std::uint32_t>(begin[tile + 1] - begin[tile]);
  }

  std::vector<std::uint64_t> cursors;       ///< scratch
  std::vector<std::int64_t> column_counts;  ///< scratch of pipeline `fast`
};

/// Throws Error(device) if lists of `pairs` entries need more than half of the machine's memory.
void refuse_if_too_many(std::uint64_t pairs);

}  // namespace qs::cpu
