// SPDX-License-Identifier: MIT
//
// Stage 2: visible Gaussians front to back, by all threads.
#pragma once

#include "raster/cpu/visible.h"

namespace qs::cpu::fast {

/// Slots of Visible by ascending (bits of depth, index in the cloud).
struct DepthOrder {
  Array<std::uint32_t> slots;

  Array<std::uint32_t> keys, other_keys, other_slots;  ///< scratch of the radix sort
  std::vector<std::uint32_t> offsets;                  ///< scratch, [segment][digit]
};

void sort(const FrameContext& frame, const VisibleSlots& visible, DepthOrder& order);

}  // namespace qs::cpu::fast
