// SPDX-License-Identifier: MIT
#include <bit>

#include "raster/cuda/fast/preprocess.cuh"
#include "raster/cuda/fast/warp.cuh"
#include "raster/cuda/train/list.cuh"

namespace qs::cuda::train {
namespace {

/// Tiles of a Gaussian that one thread lists alone.
constexpr std::uint32_t kAlone = 8;

/// Bits of a depth key that contain all depths up to 2^64 times the nearest one. More bits would
/// need another pass of the sort. Farther Gaussians would be in the order of their indices.
constexpr int kDepthBits = 29;

struct ListInput {
  classic::VisibleView visible;
  std::uint32_t gaussians;
  TileGrid grid;
  const std::uint64_t* offsets;  ///< per Gaussian: its first place; one more
  std::uint32_t nearest_bits;    ///< of the depth whose key is 0
  int depth_bits;
  std::uint64_t* keys;    ///< per place: tile << depth_bits | depth key
  std::uint32_t* places;  ///< per place: itself, to be sorted
  std::uint32_t* owners;
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
      const unsigned mask = kLanes == 1 ? (listed ? 1 : 0) : __ballot_sync(fast::kAllLanes, listed);
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
  const auto begin = static_cast<std::uint32_t>(in.offsets[gaussian]);
  const auto size = static_cast<std::uint32_t>(in.offsets[gaussian + 1]) - begin;
  const std::uint32_t bits = __float_as_uint(in.visible.depths[gaussian]);
  const std::uint64_t farthest = (std::uint64_t{1} << in.depth_bits) - 1;
  const std::uint64_t depth_key =
      min(std::uint64_t{bits > in.nearest_bits ? bits - in.nearest_bits : 0}, farthest);
  for_each_tile_in_order<P, kLanes>(
      in.visible.footprints.load(gaussian), in.grid, lane, [&](std::uint32_t k, int tile) {
        if (k >= size) return;
        in.keys[begin + k] = static_cast<std::uint64_t>(tile) << in.depth_bits | depth_key;
        in.places[begin + k] = begin + k;
        in.owners[begin + k] = gaussian;
      });
}

/// One thread per Gaussian.
template <class P>
__global__ void __launch_bounds__(kThreads) list_gaussians(ListInput in) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  const std::uint32_t count = i < in.gaussians ? in.visible.tile_counts[i] : 0;
  if (count > 0 && count <= kAlone) list_tiles<P, 1>(in, i, 0);
  const unsigned lane = fast::lane_index();
  for (unsigned large = __ballot_sync(fast::kAllLanes, count > kAlone); large != 0;
       large &= large - 1) {
    const unsigned owner = static_cast<unsigned>(__ffs(static_cast<int>(large))) - 1;
    list_tiles<P, fast::kWarp>(in, i - lane + owner, lane);
  }
}

}  // namespace

void list_pairs(const FrameContext& context, ForwardFrame& frame) {
  classic::TilePairs& pairs = frame.pairs;
  classic::count_pairs(context, frame.visible, pairs);
  if (pairs.count == 0) return;
  frame.owners.reserve("the step's pairs", frame.room());
  const std::uint32_t nearest_bits = fast::nearest_bits(context.camera);
  pairs.depth_bits = nearest_bits >= std::bit_cast<std::uint32_t>(0x1p-20f) ? kDepthBits : 32;
  with_culler(context.settings.mode, [&]<class P>(P) {
    launch("list_pairs", list_gaussians<P>, blocks_for(context.cloud.count), context.stream,
           ListInput{frame.visible.view(), context.cloud.count, context.grid, pairs.offsets.data(),
                     nearest_bits, pairs.depth_bits, pairs.buffers.keys.data(),
                     pairs.buffers.values.data(), frame.owners.data()});
  });
}

}  // namespace qs::cuda::train
