// SPDX-License-Identifier: MIT
//
// Stage 2 of the CPU backend: visible Gaussians front to back. The depth sort comes before binning
// here, so that tile lists are born sorted and no pair is ever compared.
#pragma once

#include "raster/cpu/classic/preprocess.h"

namespace qs::cpu {

/// Slots of Visible by ascending (bits of depth, index in the cloud).
struct DepthOrder {
  Array<std::uint32_t> slots;

  Array<std::uint32_t> keys, other_keys, other_slots;  ///< scratch of the radix sort
};

void sort(const FrameContext& frame, const Visible& visible, DepthOrder& order);

}  // namespace qs::cpu
