// SPDX-License-Identifier: MIT
//
// Stage 2: sorts the visible Gaussians front to back. Both CPU pipelines sort before they bin, so
// that tile lists are filled in order and pairs need no sort.
#pragma once

#include "raster/cpu/common/visible.h"

namespace qs::cpu {

/// Slots by ascending (bits of the depth, index in the cloud).
struct DepthOrder {
  Array<std::uint32_t> slots;

  Array<std::uint32_t> keys, other_keys, other_slots;  ///< scratch of the radix sort
};

void sort(const FrameContext& frame, const VisibleSlots& visible, DepthOrder& order);

}  // namespace qs::cpu
