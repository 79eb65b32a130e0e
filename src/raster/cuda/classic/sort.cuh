// SPDX-License-Identifier: MIT
//
// Stage 3 of the classic pipeline: sorts the pairs by tile, then by depth, then by index in the
// cloud, and finds the range of every tile's list.
#pragma once

#include "raster/cuda/classic/bin.cuh"

namespace qs::cuda::classic {

struct TileLists {
  DeviceBuffer<uint2> ranges;  ///< per tile: its list is the pairs [x, y)
};

void sort(const FrameContext& frame, TilePairs& pairs, TileLists& lists);

/// The same for `count` pairs of any origin, whose keys have the tile from bit `tile_bit` on. Pairs
/// of equal keys keep their order.
template <class Key>
void sort_by_tile(SortBuffers<Key>& pairs, std::uint32_t count, std::uint32_t tiles, int tile_bit,
                  cudaStream_t stream, TileLists& lists);

}  // namespace qs::cuda::classic
