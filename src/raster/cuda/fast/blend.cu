// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/segments.cuh"
#include "raster/cuda/fast/stages.cuh"
#include "raster/cuda/fast/walk.cuh"

namespace qs::cuda::fast {
namespace {

/// Draws the lists that are not cut. kMaps: draws all lists and also fills BlendOutput::evaluated
/// and used, which is slower.
template <bool kMaps, Rows kRows, bool kSlabs = false>
__global__ void __launch_bounds__(kBlendThreads, kBlendBlocks)
    blend_tiles(ScheduleView schedule, ListInput in, BlendOutput out, SegmentsView segments,
                OcclusionView occlusion) {
  constexpr Cut kCut = Walk<kMaps, kRows>::kCut;
  __shared__ Rings<kMaps> rings[kHalfTiles];
  const unsigned tile = schedule.tile(blockIdx.x), warp = threadIdx.x / kWarp;
  const HalfTile half(tile, warp, in.columns);
  const ListRange range = in.ranges[tile];
  if (!kMaps && segments.first_segments[tile] != SegmentsView::kUncut && segments.are_used())
    return;

  if (kSlabs && occlusion.slab > 0 && range.size() == 0) return;

  Column<kCut> column;
  Marks marks{{}, out.used};
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const bool exists = half.x < in.width && half.y + j < in.height;
    column.pixels[j] = {exists ? kClear<kCut> : 0.0f, in.background.x, in.background.y,
                        in.background.z};
    marks.evaluated[j] = range.size();
    if (kSlabs && occlusion.slab > 0 && exists) {
      const std::size_t at = static_cast<std::size_t>(half.y + j) * in.width + half.x;
      column.pixels[j] = {occlusion.carried(half.x, half.y + j), out.color[3 * at],
                          out.color[3 * at + 1], out.color[3 * at + 2]};
    }
  }
  Walk<kMaps, kRows>(in, half, rings[warp], column, marks).composite(range.begin, range.end);
  if (kSlabs) occlusion.record(half.x0, half.y0, column.any_live());

  if (half.x >= in.width) return;
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    if (half.y + j >= in.height) return;
    const std::size_t at = static_cast<std::size_t>(half.y + j) * in.width + half.x;
    if constexpr (kMaps)
      if (out.evaluated != nullptr) out.evaluated[at] = marks.evaluated[j];
    if (kSlabs)
      occlusion.transmittance[at] = column.pixels[j].is_live() ? column.pixels[j].transmittance : 0;
    if (out.color != nullptr) {
      out.color[3 * at] = column.pixels[j].red;
      out.color[3 * at + 1] = column.pixels[j].green;
      out.color[3 * at + 2] = column.pixels[j].blue;
    }
  }
}

}  // namespace

void blend(const FrameContext& frame, const Scratch& scratch, const Outputs& outputs,
           Pixels& pixels, const OcclusionView& occlusion, cudaStream_t stream) {
  const auto tiles = static_cast<unsigned>(frame.grid.count());
  const bool is_thin = has_thin_rows(frame.settings), cuts = cuts_long_lists(outputs);
  const auto kernel =
      occlusion.is_used() ? (is_thin ? blend_tiles<false, Rows::exponents, true>
                                     : blend_tiles<false, Rows::products, true>)
      : is_thin ? (cuts ? blend_tiles<false, Rows::exponents> : blend_tiles<true, Rows::exponents>)
                : (cuts ? blend_tiles<false, Rows::products> : blend_tiles<true, Rows::products>);
  launch("blend", kernel, Blocks(tiles, kBlendThreads), stream,
         ScheduleView{scratch.class_sizes, scratch.schedule, tiles}, scratch.lists(frame),
         BlendOutput::of(pixels, outputs), scratch.segments, occlusion);
}

}  // namespace qs::cuda::fast
