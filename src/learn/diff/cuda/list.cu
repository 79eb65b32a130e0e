// SPDX-License-Identifier: MIT
#include <algorithm>

#include "learn/diff/cuda/tiles.cuh"
#include "raster/cuda/common/block_sort.cuh"
#include "raster/cuda/common/dynamic_shared.cuh"
#include "raster/cuda/common/limits.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/kernel/cull/modes.h"

namespace qs::cuda::diff {
namespace {

/// Tiles of a Gaussian that one thread lists alone.
constexpr std::uint32_t kAlone = 8;

/// Lists above kUsualSort are sorted by a block that has the shared memory of a multiprocessor for
/// itself.
constexpr unsigned kLongBlock = 512, kLongBlocks = 128;

/// Calls visit(k, tile) for the k-th tile of a rectangle for which lists(column, row) holds, in the
/// order of tiles. All `kLanes` lanes call it; each visits some.
template <unsigned kLanes, class Lists, class Visit>
__device__ void for_each_listed(const TileRect& rect, TileGrid grid, unsigned lane,
                                const Lists& lists, const Visit& visit) {
  std::uint32_t before = 0;
  for (int row = rect.rows.begin; row < rect.rows.end; ++row) {
    for (int first = rect.columns.begin; first < rect.columns.end; first += int{kLanes}) {
      const int column = first + static_cast<int>(lane);
      const bool listed = column < rect.columns.end && lists(column, row);
      const unsigned mask = kLanes == 1 ? (listed ? 1 : 0) : __ballot_sync(kAllLanes, listed);
      const unsigned lower = mask & ((1u << lane) - 1);
      if (listed)
        visit(before + static_cast<std::uint32_t>(__popc(lower)), row * grid.columns + column);
      before += static_cast<std::uint32_t>(__popc(mask));
    }
  }
}

/// Calls visit(k, tile) for the k-th tile that mode P lists.
template <class P, unsigned kLanes, class Visit>
__device__ void for_each_tile_in_order(const Footprint& footprint, TileGrid grid, unsigned lane,
                                       const Visit& visit) {
  if constexpr (!kWalks<P>) {
    const auto lists = [&](int column, int row) {
      bool listed = false;
      P::for_each_tile_in(footprint, grid, {{column, column + 1}, {row, row + 1}},
                          [&](int, int) { listed = true; });
      return listed;
    };
    for_each_listed<kLanes>(P::bounds(footprint, grid), grid, lane, lists, visit);
  } else {
    const auto walk = P::walk(footprint, grid);
    if (walk.by_rows) {
      std::uint32_t before = 0;
      for_each_line(walk, [&](int row, Span span) {
        const auto size = static_cast<std::uint32_t>(span.size());
        for (std::uint32_t k = lane; k < size; k += kLanes)
          visit(before + k, row * grid.columns + span.begin + static_cast<int>(k));
        before += size;
      });
      return;
    }
    const Span columns = walk.lines;
    if (columns.size() == 0) return;
    const int own_column = min(columns.begin + static_cast<int>(lane), columns.end - 1);
    const Span own = walk.span(own_column);
    const auto lists = [&](int column, int row) {
      return (column == own_column ? own : walk.span(column)).contains(row);
    };
    for_each_listed<kLanes>({columns, walk.widest()}, grid, lane, lists, visit);
  }
}

template <class P, unsigned kLanes>
__device__ void list_tiles(const ListInput& in, std::uint32_t gaussian, unsigned lane) {
  const std::uint32_t begin = in.first_places[gaussian], size = in.tile_counts[gaussian];
  for_each_tile_in_order<P, kLanes>(in.footprints.load(gaussian), in.grid, lane,
                                    [&](std::uint32_t k, int tile) {
                                      if (k >= size) return;
                                      const std::uint32_t place = begin + k;
                                      in.out.owners[place] = gaussian;
                                      in.out.tiles[place] = static_cast<std::uint32_t>(tile);
                                    });
}

/// One thread per Gaussian; a warp shares the tiles of large ones. Neighbours in the model are
/// often large together, so the Gaussians of a warp are far apart.
template <class P>
__global__ void __launch_bounds__(kThreads) list_gaussians(ListInput in) {
  if (!in.out.fits()) return;
  const unsigned lane = lane_index();
  const std::uint32_t thread = blockIdx.x * kThreads + threadIdx.x;
  const std::uint32_t warp = thread / kWarp, warps = gridDim.x * (kThreads / kWarp);
  const std::uint32_t gaussian = lane * warps + warp;
  const std::uint32_t count = gaussian < in.gaussians ? in.tile_counts[gaussian] : 0;
  if (count > 0 && count <= kAlone) list_tiles<P, 1>(in, gaussian, 0);
  for (unsigned large = __ballot_sync(kAllLanes, count > kAlone); large != 0; large &= large - 1) {
    const unsigned owner = lowest_bit(large);
    list_tiles<P, kWarp>(in, owner * warps + warp, lane);
  }
}

/// One thread per place for which there is room. Not while pairs are listed, because warps would
/// wait for the result of every addition.
__global__ void __launch_bounds__(kThreads) take_slots(ListArrays lists) {
  const std::uint32_t place = blockIdx.x * kThreads + threadIdx.x;
  const bool exists = lists.fits() && place < *lists.total;
  const std::uint32_t tile = exists ? lists.tiles[place] : kNoTile;
  const std::uint32_t slot = reserve_slot_of(tile, exists, lists.sizes);
  if (exists) lists.slots[place] = slot;
}

/// Finds the ranges of the lists and the order of the tiles. One block.
__global__ void __launch_bounds__(kLongBlock) find_ranges(ListArrays lists) {
  __shared__ std::uint32_t class_sizes[kLengthClasses];
  if (threadIdx.x < kLengthClasses) class_sizes[threadIdx.x] = 0;
  __syncthreads();
  const bool fits = lists.fits();
  std::uint32_t before = 0;
  for (unsigned first = 0; first < lists.tile_count; first += kLongBlock) {
    const unsigned tile = first + threadIdx.x;
    const std::uint32_t size = fits && tile < lists.tile_count ? lists.sizes[tile] : 0;
    const auto sum = sum_of_block<kLongBlock>(size);
    if (tile < lists.tile_count) {
      const std::uint32_t begin = before + sum.before;
      lists.ranges[tile] = {begin, begin + size};
      const unsigned own = length_class(size);
      lists.scheduled[own * lists.tile_count + atomicAdd(&class_sizes[own], 1u)] = tile;
    }
    before += sum.total;
  }
  __syncthreads();
  if (threadIdx.x < kLengthClasses) lists.class_sizes[threadIdx.x] = class_sizes[threadIdx.x];
}

/// One thread per place for which there is room.
__global__ void __launch_bounds__(kThreads) fill_lists(ListArrays lists) {
  const std::uint32_t place = blockIdx.x * kThreads + threadIdx.x;
  if (!lists.fits() || place >= *lists.total) return;
  const std::uint32_t begin = lists.ranges[lists.tiles[place]].x;
  lists.entries[begin + lists.slots[place]] = {lists.depth_keys[lists.owners[place]], place};
}

/// Sorts a list with the kBlock threads of a block.
template <unsigned kBlock, class Arrays>
__device__ void sort_list(const ListArrays& lists, uint2 range, Arrays arrays) {
  const std::uint32_t size = range.y - range.x;
  const SortEntry* const entries = lists.entries + range.x;
  BlockSort<kBlock, Arrays>(arrays, entries, EntryOrder{lists.owners}, size).sort();
  __syncthreads();
  for (std::uint32_t k = threadIdx.x; k < size; k += kBlock)
    lists.places[range.x + k] = entries[arrays.order[k]].place;
  __syncthreads();
}

/// One block per tile.
__global__ void __launch_bounds__(kThreads) sort_usual_lists(ListArrays lists) {
  const ScheduleView schedule{lists.class_sizes, lists.scheduled, lists.tile_count};
  const uint2 range = lists.ranges[schedule.tile(blockIdx.x)];
  if (range.x == range.y || range.y - range.x > kUsualSort) return;
  sort_list<kThreads>(lists, range, SharedArrays(dynamic_shared(), kUsualSort));
}

/// Blocks take the other tiles in turns. `shared` is the size of a list that a block can sort in
/// shared memory; longer lists are sorted where their pairs were listed.
__global__ void __launch_bounds__(kLongBlock)
    sort_long_lists(ListArrays lists, std::uint32_t shared) {
  const ScheduleView schedule{lists.class_sizes, lists.scheduled, lists.tile_count};
  for (unsigned turn = blockIdx.x; turn < lists.tile_count; turn += gridDim.x) {
    const uint2 range = lists.ranges[schedule.tile(turn)];
    const std::uint32_t size = range.y - range.x;
    // Tiles come in half octaves of the lengths of their lists, the longest first.
    if (2 * size <= kUsualSort) return;
    if (size <= kUsualSort) continue;
    if (size <= shared) {
      sort_list<kLongBlock>(lists, range, SharedArrays(dynamic_shared(), shared));
    } else {
      GlobalArrays arrays(nullptr, 0);
      arrays.values = lists.tiles + range.x;
      arrays.order = lists.slots + range.x;
      arrays.other = lists.places + range.x;
      sort_list<kLongBlock>(lists, range, arrays);
    }
  }
}

}  // namespace

void list_pairs(CullMode mode, const ListInput& in, cudaStream_t stream) {
  const ListArrays& lists = in.out;
  set_zero("list", lists.sizes, lists.tile_count, stream);
  if (in.gaussians > 0 && lists.room > 0)
    with_culler(mode, [&]<class P>(P) {
      launch("list_pairs", list_gaussians<P>, blocks_for(in.gaussians), stream, in);
    });
  if (lists.room > 0) launch("take_slots", take_slots, blocks_for(lists.room), stream, lists);
  launch("find_ranges", find_ranges, Blocks(1, kLongBlock), stream, lists);
  if (lists.room == 0) return;
  launch("fill_lists", fill_lists, blocks_for(lists.room), stream, lists);
  const std::uint32_t shared = most_in_shared_memory();
  launch("sort_long_lists", sort_long_lists,
         Blocks(std::min(lists.tile_count, kLongBlocks), kLongBlock, SharedArrays::bytes(shared)),
         stream, lists, shared);
  launch("sort_usual_lists", sort_usual_lists,
         Blocks(lists.tile_count, kThreads, SharedArrays::bytes(kUsualSort)), stream, lists);
}

}  // namespace qs::cuda::diff
