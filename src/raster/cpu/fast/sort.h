// SPDX-License-Identifier: MIT
//
// Stage 2: sorts the visible Gaussians front to back. Every thread owns a band of tile rows and
// sorts the Gaussians that reach it, so that threads never wait for each other. Few Gaussians reach
// two bands.
#pragma once

#include <memory>

#include "raster/cpu/fast/preprocess.h"
#include "raster/scene/radix_sort.h"

namespace qs::cpu::fast {

/// The Gaussians of a band of tile rows.
struct Band {
  int top = 0, bottom = 0;  ///< tile rows [top, bottom)
  SortItems items;          ///< keys: bits of the depths, values: slots

  const Array<std::uint32_t>& slots() const { return items.values; }

  ThreadPool alone{1};  ///< scratch: it runs the band's loops on the thread that calls it
};

/// Slots by ascending (bits of the depth, index in the cloud) in every band, a band per thread.
using FastDepthOrder = std::vector<std::unique_ptr<Band>>;

void sort(const FrameContext& frame, const FastVisible& visible, FastDepthOrder& order);

}  // namespace qs::cpu::fast
