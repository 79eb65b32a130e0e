// SPDX-License-Identifier: MIT
#include "raster/cuda/dynamic_shared.cuh"
#include "raster/cuda/fast/list_block.cuh"

namespace qs::cuda::fast {
namespace {

/// A block per macro-tile. If `leaves_full`, list_full() writes the ranges of full ones.
__global__ void __launch_bounds__(kUsualThreads, kUsualBlocks)
    list_macro_tiles(MacroTiles macro_tiles, Lists out, bool leaves_full) {
  const std::uint32_t own = macro_tiles.order[blockIdx.x], size = macro_tiles.counts[own];
  const bool is_full = size >= MacroTiles::kUsual;
  if (is_full && leaves_full) return;
  const std::size_t first = std::size_t{own} * MacroTiles::kUsual;
  using Block = ListBlock<kUsualThreads>;
  static_assert(Block::kParts == 1);
  __shared__ Block::Shared shared;
  Block block(SharedArrays(dynamic_shared(), MacroTiles::kUsual), shared, is_full ? 0 : size);
  block.sort(macro_tiles.entries + first, macro_tiles.masks + first);
  block.count();
  if (threadIdx.x < kWarp) {
    const unsigned lane = lane_index();
    const std::uint32_t length = lane < Block::kTiles ? shared.lengths[0][lane] : 0;
    const std::uint64_t begin =
        place_list(out, tiles_of(macro_tiles, own, out.grid), length);
    if (lane < Block::kTiles) shared.begins[lane] = begin;
  }
  __syncthreads();
  block.write(out);
}

}  // namespace

void list_usual(const FrameContext& frame, const FrameSize& size, Scratch& scratch,
                TilePairs& pairs) {
  launch("sort", list_macro_tiles,
         Blocks(static_cast<unsigned>(scratch.macro_tiles.count()), kUsualThreads,
                SharedArrays::bytes(MacroTiles::kUsual)),
         frame.stream, scratch.macro_tiles, Lists::of(frame, size, scratch, pairs),
         size.full.exists());
}

}  // namespace qs::cuda::fast
