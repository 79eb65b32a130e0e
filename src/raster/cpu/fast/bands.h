// SPDX-License-Identifier: MIT
//
// Bands of tile rows, one per thread. Every band has its own list of Gaussians, sorted front to
// back, so that threads do not wait for each other. A Gaussian on the border of two bands is in
// both.
#pragma once

#include <memory>

#include "raster/cpu/fast/preprocess.h"
#include "raster/scene/radix_sort.h"

namespace qs::cpu::fast {

struct Band {
  int top = 0, bottom = 0;  ///< tile rows [top, bottom)
  SortItems items;          ///< keys: bits of the depths, values: slots
  ThreadPool alone{1};      ///< scratch: runs the band's loops on the thread that calls it

  const Array<std::uint32_t>& slots() const { return items.values; }

  /// Fills `items` with the Gaussians that reach the band, in order of slots. Returns the range of
  /// the keys.
  KeyRange gather(const FastVisible& visible);
};

using Bands = std::vector<std::unique_ptr<Band>>;

/// Divides the tile rows into a band per thread, with about the same number of pairs.
void find_bands(const FrameContext& frame, const FastVisible& visible, Bands& bands);

}  // namespace qs::cpu::fast
