// SPDX-License-Identifier: MIT
#include <algorithm>
#include <bit>

#include "raster/cuda/classic/classic.cuh"
#include "raster/cuda/common/limits.cuh"
#include "raster/kernel/cull/modes.h"

namespace qs::cuda::classic {
namespace {

/// One thread per Gaussian enumerates its tiles again and writes a pair for each, but never more
/// than the preprocess kernel counted.
template <class P>
__global__ void __launch_bounds__(kThreads)
    duplicate(ClassicVisibleView visible, std::uint32_t gaussians, TileGrid grid,
              const std::uint64_t* offsets, std::uint64_t* keys, std::uint32_t* values) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= gaussians || visible.tile_counts[i] == 0) return;
  auto slot = static_cast<std::uint32_t>(offsets[i]);
  const auto end = static_cast<std::uint32_t>(offsets[i + 1]);
  const std::uint64_t depth_bits = __float_as_uint(visible.depths[i]);
  for_each_tile<P>(visible.footprints.load(i), grid, [&](int tile) {
    if (slot == end) return;
    keys[slot] = static_cast<std::uint64_t>(tile) << kDepthBits | depth_bits;
    values[slot] = i;
    ++slot;
  });
}

// Finds offsets and the number of pairs, and makes room for the pairs.
void count_pairs(const FrameContext& frame, ClassicVisible& visible, ClassicPairs& pairs) {
  const std::uint32_t gaussians = frame.cloud.count;
  pairs.count = 0;
  pairs.offsets.reserve("the frame's Gaussians", std::size_t{gaussians} + 1);
  exclusive_sum(visible.tile_counts.data(), pairs.offsets.data(), gaussians + 1,
                pairs.buffers.scratch, frame.stream);
  check(cudaMemcpyAsync(&*pairs.total, pairs.offsets.data() + gaussians, sizeof(std::uint64_t),
                        cudaMemcpyDeviceToHost, frame.stream),
        "bin");
  check(cudaStreamSynchronize(frame.stream), "preprocess and bin");
  frame.throw_if_cancelled();
  require_indexable(*pairs.total);
  pairs.count = static_cast<std::uint32_t>(*pairs.total);
  if (pairs.count > 0) pairs.buffers.reserve("the frame's tile pairs", pairs.count);
}

}  // namespace

void bin(const FrameContext& frame, ClassicVisible& visible, ClassicPairs& pairs) {
  count_pairs(frame, visible, pairs);
  if (pairs.count == 0) return;
  const std::uint32_t gaussians = frame.cloud.count;
  with_culler(frame.settings.mode, [&]<class P>(P) {
    launch("duplicate", duplicate<P>, blocks_for(gaussians), frame.stream, visible.view(),
           gaussians, frame.grid, pairs.offsets.data(), pairs.buffers.keys.data(),
           pairs.buffers.values.data());
  });
}

void sort(const FrameContext& frame, ClassicPairs& pairs) {
  const auto tiles = static_cast<unsigned>(frame.grid.count());
  pairs.ranges.reserve("the frame's tiles", tiles);
  set_zero("sort", pairs.ranges.data(), tiles, frame.stream);
  if (pairs.count == 0) return;
  // At least one bit, also for a picture of one tile.
  const int tile_bits = std::max(1, static_cast<int>(std::bit_width(tiles - 1)));
  // The pairs are in ascending order of the Gaussian's index, and a Gaussian has at most one pair
  // per tile. The sort is stable, so pairs of equal depth stay in that order.
  sort_pairs(pairs.buffers, pairs.count, kDepthBits + tile_bits, frame.stream);
  // The threads of the first and last pair of a tile write its range.
  for_each_item("find_ranges", pairs.count, frame.stream,
                [keys = pairs.buffers.keys.data(), count = pairs.count,
                 ranges = pairs.ranges.data()] __device__(std::uint32_t i) {
                  const auto tile_of = [&](std::uint32_t pair) { return keys[pair] >> kDepthBits; };
                  const std::uint64_t tile = tile_of(i);
                  if (i == 0 || tile_of(i - 1) != tile) ranges[tile].begin = i;
                  if (i + 1 == count || tile_of(i + 1) != tile) ranges[tile].end = i + 1;
                });
}

}  // namespace qs::cuda::classic
