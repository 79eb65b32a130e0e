// SPDX-License-Identifier: MIT
#include "raster/cuda/pair_limit.cuh"
#include "raster/cuda/train/list.cuh"
#include "raster/cuda/warp.cuh"
#include "raster/kernel/cull/modes.h"

namespace qs::cuda::train {
namespace {

/// Tiles of a Gaussian that one thread lists alone.
constexpr std::uint32_t kAlone = 8;

struct ListInput {
  const std::uint32_t* gaussians;  ///< by rank
  const std::uint32_t* counts;     ///< by rank: tiles
  const std::uint64_t* offsets;    ///< by rank: the first place
  std::uint32_t ranks;
  FootprintArrays footprints;  ///< by Gaussian
  TileGrid grid;
  std::uint32_t* tiles;   ///< per place
  std::uint32_t* places;  ///< per place: itself, to be sorted
  std::uint32_t* owners;  ///< per place: its Gaussian
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
__device__ void list_tiles(const ListInput& in, std::uint32_t rank, unsigned lane) {
  const std::uint32_t gaussian = in.gaussians[rank], size = in.counts[rank];
  const auto begin = static_cast<std::uint32_t>(in.offsets[rank]);
  for_each_tile_in_order<P, kLanes>(in.footprints.load(gaussian), in.grid, lane,
                                    [&](std::uint32_t k, int tile) {
                                      if (k >= size) return;
                                      in.tiles[begin + k] = static_cast<std::uint32_t>(tile);
                                      in.places[begin + k] = begin + k;
                                      in.owners[begin + k] = gaussian;
                                    });
}

/// One thread per rank. Near Gaussians are large, so the ranks of a warp are far apart.
template <class P>
__global__ void __launch_bounds__(kThreads) list_gaussians(ListInput in) {
  const unsigned lane = lane_index();
  const std::uint32_t thread = blockIdx.x * kThreads + threadIdx.x;
  const std::uint32_t warp = thread / kWarp, warps = gridDim.x * (kThreads / kWarp);
  const std::uint32_t rank = lane * warps + warp;
  const std::uint32_t count = rank < in.ranks ? in.counts[rank] : 0;
  if (count > 0 && count <= kAlone) list_tiles<P, 1>(in, rank, 0);
  for (unsigned large = __ballot_sync(kAllLanes, count > kAlone); large != 0; large &= large - 1) {
    const unsigned owner = static_cast<unsigned>(__ffs(static_cast<int>(large))) - 1;
    list_tiles<P, kWarp>(in, owner * warps + warp, lane);
  }
}

}  // namespace

void list_pairs(const StepView& view, std::uint32_t count, ForwardFrame& frame) {
  constexpr const char* kWhat = "the step's pairs";
  ListedPairs& pairs = frame.pairs;
  pairs.count = 0;
  frame.total.arrived.wait();
  view.throw_if_cancelled();
  require_indexable(*frame.total.copy);
  pairs.count = static_cast<std::uint32_t>(*frame.total.copy);
  if (pairs.count == 0) return;
  pairs.buffers.reserve(kWhat, pairs.count);
  pairs.owners.reserve(kWhat, frame.room());
  with_culler(view.settings.mode, [&]<class P>(P) {
    launch("list_pairs", list_gaussians<P>, blocks_for(count), view.stream,
           ListInput{frame.order.gaussians(), frame.order.counts.data(), frame.order.offsets.data(),
                     count, frame.footprints.arrays(), view.grid(), pairs.buffers.keys.data(),
                     pairs.buffers.values.data(), pairs.owners.data()});
  });
}

}  // namespace qs::cuda::train
