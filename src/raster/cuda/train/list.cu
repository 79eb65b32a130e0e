// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/dynamic_shared.cuh"
#include "raster/cuda/fast/list.cuh"
#include "raster/cuda/fast/macro_sort.cuh"
#include "raster/cuda/pair_limit.cuh"
#include "raster/cuda/train/list.cuh"
#include "raster/cuda/warp.cuh"
#include "raster/kernel/cull/modes.h"

namespace qs::cuda::train {
namespace {

/// Tiles of a Gaussian that one thread lists alone.
constexpr std::uint32_t kAlone = 8;

/// Longer lists are sorted by a block that has the shared memory of a multiprocessor for itself.
constexpr std::uint32_t kUsualList = 3072;
constexpr unsigned kLongBlock = 512, kLongBlocks = 128;

/// The arrays of ForwardFrame.
struct Lists {
  const unsigned long long* total;  ///< pairs
  std::uint32_t room;               ///< for pairs; if there are more, nothing is listed
  const std::uint32_t* depth_keys;
  std::uint32_t *owners, *tiles, *slots;
  fast::MacroEntry* entries;
  std::uint32_t* places;
  std::uint32_t* sizes;
  uint2* ranges;
  std::uint32_t *class_sizes, *scheduled;
  unsigned tile_count;

  __device__ bool fits() const { return *total <= room; }
};

struct ListInput {
  std::uint32_t gaussians;
  const std::uint32_t *tile_counts, *first_places;
  FootprintArrays footprints;
  TileGrid grid;
  Lists out;
};

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

/// The same for the tiles that mode P lists.
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
    const unsigned owner = static_cast<unsigned>(__ffs(static_cast<int>(large))) - 1;
    list_tiles<P, kWarp>(in, owner * warps + warp, lane);
  }
}

/// One thread per place for which there is room. Not while pairs are listed, because warps would
/// wait for the result of every addition.
__global__ void __launch_bounds__(kThreads) take_slots(Lists lists) {
  const std::uint32_t place = blockIdx.x * kThreads + threadIdx.x;
  if (!lists.fits() || place >= *lists.total) return;
  lists.slots[place] = atomicAdd(&lists.sizes[lists.tiles[place]], 1u);
}

/// Finds the ranges of the lists and the order of the tiles. One block.
__global__ void __launch_bounds__(kLongBlock) find_ranges(Lists lists) {
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
__global__ void __launch_bounds__(kThreads) fill_lists(Lists lists) {
  const std::uint32_t place = blockIdx.x * kThreads + threadIdx.x;
  if (!lists.fits() || place >= *lists.total) return;
  const std::uint32_t begin = lists.ranges[lists.tiles[place]].x;
  lists.entries[begin + lists.slots[place]] = {lists.depth_keys[lists.owners[place]], place};
}

/// Sorts a list with the kBlock threads of a block.
template <unsigned kBlock, class Arrays>
__device__ void sort_list(const Lists& lists, uint2 range, Arrays arrays) {
  const std::uint32_t size = range.y - range.x;
  const fast::MacroEntry* const entries = lists.entries + range.x;
  fast::MacroSort<kBlock, Arrays>(arrays, entries, fast::EntryOrder{lists.owners}, size).sort();
  __syncthreads();
  for (std::uint32_t k = threadIdx.x; k < size; k += kBlock)
    lists.places[range.x + k] = entries[arrays.order[k]].place;
  __syncthreads();
}

/// One block per tile.
__global__ void __launch_bounds__(kThreads) sort_usual_lists(Lists lists) {
  const ScheduleView schedule{lists.class_sizes, lists.scheduled, lists.tile_count};
  const uint2 range = lists.ranges[schedule.tile(blockIdx.x)];
  if (range.x == range.y || range.y - range.x > kUsualList) return;
  sort_list<kThreads>(lists, range, fast::SharedArrays(dynamic_shared(), kUsualList));
}

/// Blocks take the other tiles in turns. `shared` is the size of a list that a block can sort in
/// shared memory; longer lists are sorted where their pairs were listed.
__global__ void __launch_bounds__(kLongBlock) sort_long_lists(Lists lists, std::uint32_t shared) {
  const ScheduleView schedule{lists.class_sizes, lists.scheduled, lists.tile_count};
  for (unsigned turn = blockIdx.x; turn < lists.tile_count; turn += gridDim.x) {
    const uint2 range = lists.ranges[schedule.tile(turn)];
    const std::uint32_t size = range.y - range.x;
    // Tiles come in half octaves of the lengths of their lists, the longest first.
    if (2 * size <= kUsualList) return;
    if (size <= kUsualList) continue;
    if (size <= shared) {
      sort_list<kLongBlock>(lists, range, fast::SharedArrays(dynamic_shared(), shared));
    } else {
      fast::GlobalArrays arrays(nullptr, 0);
      arrays.values = lists.tiles + range.x;
      arrays.order = lists.slots + range.x;
      arrays.other = lists.places + range.x;
      sort_list<kLongBlock>(lists, range, arrays);
    }
  }
}

/// Enqueues the listing of the pairs, which lists nothing if there are more than frame.pairs has
/// room for.
void enqueue_lists(const StepView& view, std::uint32_t count, ForwardFrame& frame) {
  ListedPairs& pairs = frame.pairs;
  const auto tiles = static_cast<unsigned>(view.grid().count());
  check(cudaMemsetAsync(frame.lists.sizes.data(), 0, tiles * sizeof(std::uint32_t), view.stream),
        "list");
  const Lists lists{frame.total.sum.data(),
                    pairs.room(),
                    frame.depth_keys.data(),
                    pairs.owners.data(),
                    pairs.tiles.data(),
                    pairs.slots.data(),
                    pairs.entries.data(),
                    pairs.places.data(),
                    frame.lists.sizes.data(),
                    frame.lists.ranges.data(),
                    frame.lists.class_sizes.data(),
                    frame.lists.scheduled.data(),
                    tiles};
  if (count > 0 && pairs.room() > 0) {
    with_culler(view.settings.mode, [&]<class P>(P) {
      launch("list_pairs", list_gaussians<P>, blocks_for(count), view.stream,
             ListInput{count, frame.tile_counts.data(), frame.first_places.data(),
                       frame.footprints.arrays(), view.grid(), lists});
    });
  }
  if (pairs.room() > 0)
    launch("take_slots", take_slots, blocks_for(pairs.room()), view.stream, lists);
  launch("find_ranges", find_ranges, Blocks(1, kLongBlock), view.stream, lists);
  if (pairs.room() == 0) return;
  launch("fill_lists", fill_lists, blocks_for(pairs.room()), view.stream, lists);
  const std::uint32_t shared = fast::most_in_shared_memory();
  launch("sort_long_lists", sort_long_lists,
         Blocks(std::min(tiles, kLongBlocks), kLongBlock, fast::SharedArrays::bytes(shared)),
         view.stream, lists, shared);
  launch("sort_usual_lists", sort_usual_lists,
         Blocks(tiles, kThreads, fast::SharedArrays::bytes(kUsualList)), view.stream, lists);
}

}  // namespace

void ListedPairs::reserve(std::uint32_t pairs) {
  if (pairs <= room()) return;  // places is reserved last
  constexpr const char* kWhat = "the step's pairs";
  constexpr auto bytes_for = [](std::uint64_t count) {
    return count * (4 * sizeof(std::uint32_t) + sizeof(fast::MacroEntry));
  };
  const std::uint64_t held = bytes_for(room());
  require_memory(kWhat, bytes_for(pairs), held);
  const std::uint32_t more = with_headroom(pairs, UINT32_MAX, held, bytes_for);
  places.release();
  for (auto* buffer : {&owners, &tiles, &slots}) buffer->reserve(kWhat, more);
  entries.reserve(kWhat, more);
  places.reserve(kWhat, more);
}

void TileLists::reserve(unsigned tiles) {
  constexpr const char* kWhat = "the step's tiles";
  sizes.reserve(kWhat, tiles);
  ranges.reserve(kWhat, tiles);
  class_sizes.reserve(kWhat, kLengthClasses);
  scheduled.reserve(kWhat, std::size_t{kLengthClasses} * tiles);
}

void list_view(const StepView& view, std::uint32_t count, ForwardFrame& frame) {
  frame.pairs.count = 0;
  frame.lists.reserve(static_cast<unsigned>(view.grid().count()));
  enqueue_lists(view, count, frame);
  frame.total.arrived.wait();
  view.throw_if_cancelled();
  require_indexable(*frame.total.copy);
  const auto pairs = static_cast<std::uint32_t>(*frame.total.copy);
  if (pairs > frame.pairs.room()) {
    frame.pairs.reserve(pairs);
    enqueue_lists(view, count, frame);
  }
  frame.pairs.count = pairs;
}

}  // namespace qs::cuda::train
