// SPDX-License-Identifier: MIT
#include "raster/cuda/classic/sort.cuh"

namespace qs::cuda::classic {

void sort(const FrameContext& frame, ClassicPairs& pairs, TileLists& lists) {
  // The pairs are in ascending order of the Gaussian's index, and a Gaussian has at most one pair
  // per tile. The sort is stable, so pairs of equal depth stay in that order.
  sort_by_tile(pairs.buffers, pairs.count, static_cast<std::uint32_t>(frame.grid.count()),
               kDepthBits, frame.stream, lists);
}

}  // namespace qs::cuda::classic
