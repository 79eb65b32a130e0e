// SPDX-License-Identifier: MIT
#include <algorithm>
#include <bit>

#include "raster/cuda/common/tile_lists.cuh"

namespace qs::cuda {
namespace {

/// One thread per pair; the threads of the first and last pair of a tile write its range.
__global__ void find_ranges(const std::uint64_t* keys, std::uint32_t count, int tile_bit,
                            uint2* ranges) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= count) return;
  const auto tile_of = [&](std::uint32_t pair) { return keys[pair] >> tile_bit; };
  const std::uint64_t tile = tile_of(i);
  if (i == 0 || tile_of(i - 1) != tile) ranges[tile].x = i;
  if (i + 1 == count || tile_of(i + 1) != tile) ranges[tile].y = i + 1;
}

}  // namespace

void sort_by_tile(SortBuffers& pairs, std::uint32_t count, std::uint32_t tiles, int tile_bit,
                  cudaStream_t stream, TileLists& lists) {
  lists.ranges.reserve("the frame's tiles", tiles);
  check(cudaMemsetAsync(lists.ranges.data(), 0, tiles * sizeof(uint2), stream), "sort");
  if (count == 0) return;
  // At least one bit, also for a picture of one tile.
  const int tile_bits = std::max(1, static_cast<int>(std::bit_width(tiles - 1)));
  sort_pairs(pairs, count, tile_bit + tile_bits, stream);
  launch("find_ranges", find_ranges, blocks_for(count), stream, pairs.keys.data(), count, tile_bit,
         lists.ranges.data());
}

}  // namespace qs::cuda
