// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/schedule.cuh"
#include "raster/cuda/fast/segments.cuh"

namespace qs::cuda::fast {
namespace {

__global__ void __launch_bounds__(kThreads)
    schedule_tiles(const KeyRange* ranges, unsigned tiles, std::uint32_t* class_sizes,
                   std::uint32_t* scheduled, SegmentsView segments) {
  Counters* const counters = segments.counters;
  __shared__ std::uint32_t sizes[kLengthClasses], begins[kLengthClasses];
  __shared__ std::uint32_t longest;
  const unsigned thread = threadIdx.x, tile = blockIdx.x * kThreads + thread;
  if (thread < kLengthClasses) sizes[thread] = 0;
  if (thread == 0) longest = 0;
  __syncthreads();
  const std::uint32_t length = tile < tiles ? ranges[tile].size() : 0;
  const unsigned own = length_class(length);
  std::uint32_t place = 0;
  if (tile < tiles) place = atomicAdd(&sizes[own], 1u);
  if (length > 0) atomicMax(&longest, length);
  __syncthreads();
  if (class_sizes != nullptr && thread < kLengthClasses && sizes[thread] > 0) {
    begins[thread] = atomicAdd(&class_sizes[thread], sizes[thread]);
  }
  if (length > kLongList) segments.reserve(tile, segment_count(length));
  if (thread == 0 && longest > 0) atomicMax(&counters->max_pairs_in_a_tile, longest);
  __syncthreads();
  if (class_sizes != nullptr && tile < tiles) scheduled[own * tiles + begins[own] + place] = tile;
}

}  // namespace

ScheduleView schedule_view(const Scratch& scratch, TileGrid grid) {
  return {scratch.class_sizes, scratch.schedule, static_cast<unsigned>(grid.count())};
}

void schedule(const FrameContext& frame, Scratch& scratch) {
  const auto tiles = static_cast<unsigned>(frame.grid.count());
  launch("blend", schedule_tiles, blocks_for(tiles), frame.stream, scratch.ranges, tiles,
         scratch.class_sizes, scratch.schedule, scratch.segments);
}

}  // namespace qs::cuda::fast
