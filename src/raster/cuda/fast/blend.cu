// SPDX-License-Identifier: MIT
#include "raster/cuda/common/schedule.cuh"
#include "raster/cuda/fast/blend.cuh"

namespace qs::cuda::fast {
namespace {

/// Draws lists of `longest` Gaussians at most. kMaps: draws all lists and also fills
/// BlendOutput::evaluated and used, which is slower.
template <bool kMaps, Rows kRows>
__global__ void __launch_bounds__(kBlendThreads, kBlendBlocks)
    blend_tiles(ScheduleView schedule, ListInput in, BlendOutput out, std::uint32_t longest) {
  constexpr Cut kCut = Walk<kMaps, kRows>::kCut;
  __shared__ Rings<kMaps> rings[kHalfTiles];
  const unsigned tile = schedule.tile(blockIdx.x), warp = threadIdx.x / kWarp;
  const HalfTile half(tile, warp, in.columns);
  const ListRange range = in.ranges[tile];
  if (!kMaps && range.size() > longest) return;

  Column<kCut> column;
  Marks marks{{}, out.used};
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const bool exists = half.x < in.width && half.y + j < in.height;
    column.pixels[j] = {exists ? kClear<kCut> : 0.0f, in.background.x, in.background.y,
                        in.background.z};
    marks.evaluated[j] = range.size();
  }
  Walk<kMaps, kRows>(in, half, rings[warp], column, marks).composite(range.begin, range.end);

  if (half.x >= in.width) return;
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    if (half.y + j >= in.height) return;
    const std::size_t at = static_cast<std::size_t>(half.y + j) * in.width + half.x;
    if constexpr (kMaps)
      if (out.evaluated != nullptr) out.evaluated[at] = marks.evaluated[j];
    if (out.color != nullptr) {
      out.color[3 * at] = column.pixels[j].red;
      out.color[3 * at + 1] = column.pixels[j].green;
      out.color[3 * at + 2] = column.pixels[j].blue;
    }
  }
}

template <Rows kRows>
void blend_rows(const FrameContext& frame, const ListedTiles& listed, const Outputs& outputs,
                Pixels& pixels, cudaStream_t stream) {
  const Scratch& scratch = listed.scratch;
  const auto tiles = static_cast<unsigned>(frame.grid.count());
  launch("blend", cuts_long_lists(outputs) ? blend_tiles<false, kRows> : blend_tiles<true, kRows>,
         Blocks(tiles, kBlendThreads), stream,
         ScheduleView{scratch.class_sizes, scratch.schedule, tiles}, input_of(frame, listed),
         BlendOutput::of(pixels, outputs), scratch.segments.longest_uncut);
}

}  // namespace

void blend(const FrameContext& frame, const ListedTiles& listed, const Outputs& outputs,
           Pixels& pixels, cudaStream_t stream) {
  const auto of_rows =
      has_thin_rows(frame.settings) ? blend_rows<Rows::exponents> : blend_rows<Rows::products>;
  of_rows(frame, listed, outputs, pixels, stream);
}

}  // namespace qs::cuda::fast
