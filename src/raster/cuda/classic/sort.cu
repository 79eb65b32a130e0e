// SPDX-License-Identifier: MIT
#include <algorithm>
#include <bit>

#include "raster/cuda/classic/sort.cuh"

namespace qs::cuda::classic {
namespace {

/// One thread per pair; the threads of the first and last pair of a tile write its range.
__global__ void find_ranges(const std::uint64_t* keys, std::uint32_t count, ListRange* ranges) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= count) return;
  const auto tile_of = [&](std::uint32_t pair) { return keys[pair] >> kDepthBits; };
  const std::uint64_t tile = tile_of(i);
  if (i == 0 || tile_of(i - 1) != tile) ranges[tile].begin = i;
  if (i + 1 == count || tile_of(i + 1) != tile) ranges[tile].end = i + 1;
}

}  // namespace

void sort(const FrameContext& frame, ClassicPairs& pairs, TileLists& lists) {
  const auto tiles = static_cast<unsigned>(frame.grid.count());
  lists.ranges.reserve("the frame's tiles", tiles);
  set_zero("sort", lists.ranges.data(), tiles, frame.stream);
  if (pairs.count == 0) return;
  // At least one bit, also for a picture of one tile.
  const int tile_bits = std::max(1, static_cast<int>(std::bit_width(tiles - 1)));
  // The pairs are in ascending order of the Gaussian's index, and a Gaussian has at most one pair
  // per tile. The sort is stable, so pairs of equal depth stay in that order.
  sort_pairs(pairs.buffers, pairs.count, kDepthBits + tile_bits, frame.stream);
  launch("find_ranges", find_ranges, blocks_for(pairs.count), frame.stream,
         pairs.buffers.keys.data(), pairs.count, lists.ranges.data());
}

}  // namespace qs::cuda::classic
