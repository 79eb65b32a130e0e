// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/common/dynamic_shared.cuh"
#include "raster/cuda/fast/list_block.cuh"

namespace qs::cuda::fast {
namespace {

/// Lists a macro-tile, or the empty list if `size` is 0.
template <unsigned kBlock>
__device__ void list_macro_tile(const MacroTiles& macro_tiles, std::uint32_t own,
                                std::uint32_t size, std::uint32_t capacity, const Lists& out) {
  using Block = ListBlock<kBlock>;
  __shared__ typename Block::Shared shared;
  const std::size_t first = std::size_t{own} * macro_tiles.slicing.size.capacity;
  const TileRect window = tiles_of(macro_tiles, own, out.grid);
  Block block(SharedArrays(dynamic_shared(), capacity), shared, size);
  block.sort(macro_tiles.entries + first, macro_tiles.masks + first, macro_tiles.entry_order);
  block.count();
  const unsigned lane = lane_index();
  const std::uint32_t length = lane < Block::kTiles ? shared.entries.total[lane] : 0;
  const CutRule rule = CutRule::of(out.segments);
  const bool is_marked =  // equal in all warps
      out.segments.finds_samples && rule.may_cut(size) &&
      __any_sync(kAllLanes, rule.may_cut(length)) != 0;
  if (is_marked) {
    block.mark(out.samples, rule, window);
    block.count_samples();
  }
  if (threadIdx.x < kWarp) {
    const std::uint64_t begin = place_list(out, window, length);
    if (lane < Block::kTiles) {
      shared.begins[lane] = begin;
      shared.sample_begins[lane] = 0;
    }
  }
  __syncthreads();
  if (is_marked) block.cut(out, window);
  block.write(out, window, is_marked);
}

/// Launched with a block per macro-tile. A block lists a macro-tile with less than kUsual
/// Gaussians. For other macro-tiles it writes empty lists if `lists_all`, else nothing.
__global__ void __launch_bounds__(kUsualThreads, blocks_at_once(kUsualBlocks, kUsualThreads))
    list_usual_macro_tiles(MacroTiles macro_tiles, Lists out, bool lists_all) {
  const std::uint32_t own = macro_tiles.order[blockIdx.x], size = macro_tiles.counts[own];
  const bool is_usual = size < MacroTiles::kUsual;
  if (!is_usual && !lists_all) return;
  list_macro_tile<kUsualThreads>(macro_tiles, own, is_usual ? size : 0, MacroTiles::kUsual, out);
}

/// Lists the macro-tiles with at least kUsual Gaussians, which come first in the order. Blocks take
/// them in turns.
__global__ void __launch_bounds__(kLargeThreads, kLargeBlocks)
    list_whole_macro_tiles(MacroTiles macro_tiles, Lists out) {
  const std::uint32_t capacity = macro_tiles.slicing.size.capacity;
  const auto count = static_cast<unsigned>(macro_tiles.count());
  for (unsigned place = blockIdx.x; place < count; place += gridDim.x) {
    const std::uint32_t own = macro_tiles.order[place], size = macro_tiles.counts[own];
    if (size < MacroTiles::kUsual) return;
    list_macro_tile<kLargeThreads>(macro_tiles, own, size <= capacity ? size : 0, capacity, out);
  }
}

}  // namespace

void list_usual(const Scratch& scratch, cudaStream_t stream) {
  const MacroSize& macro = scratch.size.macro;
  launch("sort", list_usual_macro_tiles,
         Blocks(static_cast<unsigned>(scratch.macro_tiles.count()), kUsualThreads,
                SharedArrays::bytes(MacroTiles::kUsual)),
         stream, scratch.macro_tiles, Lists::of(scratch),
         !macro.keeps_whole() && !macro.has_slices());
}

void list_whole(const Scratch& scratch, cudaStream_t stream) {
  const auto count = static_cast<unsigned>(scratch.macro_tiles.count());
  launch("sort", list_whole_macro_tiles,
         Blocks(std::min(count, scratch.multiprocessors), kLargeThreads,
                SharedArrays::bytes(scratch.size.macro.capacity)),
         stream, scratch.macro_tiles, Lists::of(scratch));
}

}  // namespace qs::cuda::fast
