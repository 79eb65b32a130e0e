// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/blend.cuh"
#include "raster/cuda/fast/schedule.cuh"
#include "raster/cuda/fast/walk.cuh"

namespace qs::cuda::fast {
namespace {

/// kMaps: also fills BlendOutput::evaluated and used, which is slower.
template <bool kMaps>
__global__ void __launch_bounds__(kTileWarps* kWarp)
    blend_tiles(ScheduleView schedule, ListInput in, BlendOutput out) {
  constexpr Cut kCut = Walk<kMaps>::kCut;
  __shared__ Rings<kMaps> rings[kTileWarps];
  const unsigned tile = schedule.tile(blockIdx.x), warp = threadIdx.x / kWarp;
  const unsigned lane = lane_index(), sub = lane / kLanes;
  const int x0 = static_cast<int>(tile % in.columns * kTileSize);
  const int y0 = static_cast<int>(tile / in.columns * kTileSize + warp * kWarpHeight);
  const int x = x0 + static_cast<int>(sub % 2 * kSubWidth + lane % kLanes);
  const int y = y0 + static_cast<int>(sub / 2 * kSubHeight);
  const KeyRange range = in.ranges[tile];

  Column<kCut> column;
  Marks marks{{}, out.used};
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const bool exists = x < in.width && y + j < in.height;
    column.pixels[j] = {exists ? kClear<kCut> : 0.0f, in.background.x, in.background.y,
                        in.background.z};
    marks.evaluated[j] = range.size();
  }
  Walk<kMaps>(in, x0, y0, rings[warp], column, marks).composite(range.begin(), range.end);

  if (x >= in.width) return;
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    if (y + j >= in.height) return;
    const std::size_t at = static_cast<std::size_t>(y + j) * in.width + x;
    if constexpr (kMaps) {
      if (out.evaluated != nullptr) out.evaluated[at] = marks.evaluated[j];
    }
    if (out.color != nullptr) {
      out.color[3 * at] = column.pixels[j].red;
      out.color[3 * at + 1] = column.pixels[j].green;
      out.color[3 * at + 2] = column.pixels[j].blue;
    }
  }
}

}  // namespace

void blend(const FrameContext& frame, const Visible& visible, const TilePairs& pairs,
           const Scratch& scratch, const Outputs& outputs, Pixels& pixels) {
  launch("blend", outputs.evaluated || outputs.used ? blend_tiles<true> : blend_tiles<false>,
         Blocks(static_cast<unsigned>(frame.grid.count()), kTileWarps * kWarp), frame.stream,
         schedule_view(scratch, frame.grid),
         ListInput::of(frame, pairs.gaussians, std::as_const(scratch.ranges), visible.splats),
         BlendOutput::of(pixels, outputs));
}

}  // namespace qs::cuda::fast
