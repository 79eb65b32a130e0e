// SPDX-License-Identifier: MIT
//
// Stage 2: sorts the visible Gaussians front to back on all threads.
#pragma once

#include "raster/cpu/visible.h"
#include "raster/scene/radix_sort.h"

namespace qs::cpu::fast {

/// Slots by ascending (bits of the depth, index in the cloud).
struct FastDepthOrder {
  const Array<std::uint32_t>& slots() const { return items.values; }

  SortItems items;               ///< keys: bits of the depths, values: slots
  Array<std::uint32_t> begins;   ///< scratch, per chunk: its first item
  std::vector<KeyRange> ranges;  ///< scratch, per thread
};

void sort(const FrameContext& frame, const VisibleSlots& visible, FastDepthOrder& order);

}  // namespace qs::cpu::fast
