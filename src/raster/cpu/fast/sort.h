// SPDX-License-Identifier: MIT
//
// Stage 2: visible Gaussians front to back, by all threads.
#pragma once

#include "raster/cpu/fast/radix_sort.h"
#include "raster/cpu/visible.h"

namespace qs::cpu::fast {

/// Slots of Visible by ascending (bits of depth, index in the cloud).
struct DepthOrder {
  const Array<std::uint32_t>& slots() const { return items.values; }

  SortItems items;               ///< bits of depth, slot
  Array<std::uint32_t> begins;   ///< scratch, per chunk of Visible: where its items begin
  std::vector<KeyRange> ranges;  ///< scratch, per thread
};

void sort(const FrameContext& frame, const VisibleSlots& visible, DepthOrder& order);

}  // namespace qs::cpu::fast
