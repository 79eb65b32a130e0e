// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/schedule.cuh"
#include "raster/cuda/fast/segments.cuh"

namespace qs::cuda::fast {
namespace {

/// Lengths of 2^15 and more are in class 0, empty lists in the last class.
__device__ unsigned length_class(std::uint32_t length) {
  if (length == 0) return kLengthClasses - 1;
  constexpr int kMantissaBits = 23, kBias = 127;
  const unsigned bits = __float_as_uint(static_cast<float>(length));
  const unsigned half_octaves = (bits >> (kMantissaBits - 1)) - 2 * kBias;
  return half_octaves < kLengthClasses - 1 ? kLengthClasses - 2 - half_octaves : 0;
}

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
  if (length > kLongList) {
    const std::uint32_t count = segment_count(length);
    const std::uint32_t first = atomicAdd(&counters->segments, count);
    const bool fits = first + count <= segments.capacity;
    for (std::uint32_t i = 0; i < count && first + i < segments.capacity; ++i) {
      segments.segments[first + i] = {fits ? tile : Segment::kNoTile, i, 0};
    }
    const std::uint32_t list = atomicAdd(&counters->long_lists, 1u);
    if (list < segments.capacity) segments.first_segments[list] = first;
  }
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
