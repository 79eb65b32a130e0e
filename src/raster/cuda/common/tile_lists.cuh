// SPDX-License-Identifier: MIT
//
// Pairs of a tile and a Gaussian become the lists of tiles: they are sorted by keys that have the
// tile in their upper bits, and then the range of every tile is found.
#pragma once

#include "raster/cuda/common/scan_and_sort.cuh"

namespace qs::cuda {

struct TileLists {
  DeviceBuffer<uint2> ranges;  ///< per tile: its list is the pairs [x, y)
};

/// Sorts `count` pairs, whose keys have the tile from bit `tile_bit` on, by all bits of the keys.
/// Pairs of equal keys keep their order.
void sort_by_tile(SortBuffers& pairs, std::uint32_t count, std::uint32_t tiles, int tile_bit,
                  cudaStream_t stream, TileLists& lists);

}  // namespace qs::cuda
