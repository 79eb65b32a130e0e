// SPDX-License-Identifier: MIT
#include "learn/diff/cuda/blend.h"
#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/diff/cuda/segment.cuh"
#include "raster/kernel/composite.h"

namespace qs::cuda::diff {
namespace {

/// A tile is one block with one thread per pixel.
__global__ void __launch_bounds__(kThreads)
    count_tile(ScheduleView schedule, TilesView in, PixelRules<float> rules, float behind,
               Rows<std::int32_t> counts) {
  __shared__ SharedSegment segment;
  __shared__ std::int32_t pixels[kSegment];
  const std::uint32_t tile = schedule.tile(blockIdx.x);
  const unsigned thread = threadIdx.x;
  const int x = in.x_of(tile, thread), y = in.y_of(tile, thread);
  const uint2 range = in.ranges[tile];

  bool live = in.contains(x, y);
  float transmittance = 1;
  for (std::uint32_t first = range.x; first < range.y; first += kSegment) {
    if (__syncthreads_count(live) == 0) break;
    const std::uint32_t size = min(range.y - first, kSegment);
    segment.load(in, tile, first, size);
    pixels[thread] = 0;
    __syncthreads();
    for (std::uint32_t group = 0; group < size && __any_sync(kAllLanes, live); group += kWarp) {
      for (unsigned reaching = segment.reaching(group, size); reaching != 0;
           reaching &= reaching - 1) {
        const std::uint32_t entry = group + lowest_bit(reaching);
        bool counted = false;
        if (live) {
          float alpha = 0;
          const Step step = composite(segment.splat(entry), static_cast<float>(x),
                                      static_cast<float>(y), transmittance, alpha, rules);
          counted = step == Step::blends && transmittance > behind;
          // The Gaussians behind one that does not count do not count either.
          live = counted || step == Step::skips;
        }
        const unsigned all = __ballot_sync(kAllLanes, counted);
        if (all != 0 && lane_index() == 0) atomicAdd(&pixels[entry], __popc(all));
      }
    }
    __syncthreads();
    if (thread < size && pixels[thread] > 0)
      atomicAdd(&counts.at(in.owners[in.places[first + thread]]), pixels[thread]);
  }
}

}  // namespace

void count_pixels(const PixelRules<float>& rules, const Frame& frame, float behind,
                  const Queue& queue, const Rows<std::int32_t>& counts) {
  queue.throw_if_cancelled();
  const ListedFrame listed = ListedFrame::of(frame);
  for_each_item("count pixels", frame.sizes.gaussians, stream_of(queue),
                [=] __device__(std::uint32_t i) { counts.at(i) = 0; });
  launch("count pixels", count_tile, tiles_of(listed.sizes), stream_of(queue), listed.schedule(),
         listed.tiles(), rules, behind, counts);
}

}  // namespace qs::cuda::diff
