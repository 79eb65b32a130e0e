// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/bin.cuh"

namespace qs::cuda::fast {
namespace {

struct BinInput {
  const std::uint32_t* order;
  const Shape* shapes;
  TileGrid grid;
  std::uint32_t room;  // for pairs
};

template <class Key>
struct BinOutput {
  Key* keys;
  std::uint32_t* gaussians;
  Counters* counters;
  std::uint32_t* digit_counts;
  volatile std::uint64_t* words;  // look-back
};

/// Writes the pairs of a block and counts their digits.
template <class Key>
struct Writer {
  static constexpr int kPasses = Radix<Key>::kPasses;
  static constexpr unsigned kCounts = kPasses * kBins<Key>;
  const BinOutput<Key>& out;
  std::uint32_t room;
  std::uint32_t* digit_counts;  // shared, kCounts

  __device__ void write(std::uint64_t slot, Key tile, std::uint32_t gaussian) const {
    if (slot >= room) return;
    out.keys[slot] = tile;
    out.gaussians[slot] = gaussian;
    for (int pass = 0; pass < kPasses; ++pass) {
      atomicAdd(&digit_counts[pass * kBins<Key> + digit_of(tile, pass)], 1u);
    }
  }
};

/// The whole warp writes the pairs of one Gaussian: a lane finds the span of a line, then all write
/// it side by side.
template <class P, class Key>
__device__ void write_together(const Shape& shape, std::uint32_t gaussian, std::uint64_t slot,
                               TileGrid grid, const Writer<Key>& writer) {
  const Footprint footprint = shape.footprint();
  const std::uint64_t end = min(slot + shape.tiles, std::uint64_t{writer.room});
  if constexpr (requires { P::walk(footprint, grid); }) {
    const auto walk = P::walk(footprint, grid);
    const int lane = static_cast<int>(lane_index());
    for (int first = walk.lines.begin; first < walk.lines.end && slot < end; first += kWarp) {
      const Span mine = first + lane < walk.lines.end ? walk.span(first + lane) : Span{0, 0};
      for (int k = 0; k < static_cast<int>(kWarp) && first + k < walk.lines.end; ++k) {
        const Span span{__shfl_sync(kAllLanes, mine.begin, k), __shfl_sync(kAllLanes, mine.end, k)};
        for (int i = lane; i < span.size(); i += kWarp) {
          const int line = first + k, at = span.begin + i;
          const int tile = walk.by_rows ? line * grid.columns + at : at * grid.columns + line;
          if (slot + i < end) writer.write(slot + i, static_cast<Key>(tile), gaussian);
        }
        slot += span.size();
      }
    }
  } else if (lane_index() == 0) {
    P::for_each_tile(footprint, grid, [&](int tile) {
      if (slot < end) writer.write(slot++, static_cast<Key>(tile), gaussian);
    });
  }
}

/// A thread per visible Gaussian, front to back. A warp's pairs lie side by side: it collects them
/// in shared memory and writes them in one go, unless they are too many.
template <class P, class Key>
__global__ void __launch_bounds__(kThreads) list_tiles(BinInput in, BinOutput<Key> out) {
  constexpr std::uint32_t kCollected = 2048 / sizeof(Key);  // pairs of a warp
  constexpr unsigned kCounts = Writer<Key>::kCounts;
  __shared__ std::uint32_t digit_counts[kCounts];
  __shared__ Key tiles_of_warp[kWarps][kCollected];
  __shared__ std::uint8_t lane_of_tile[kWarps][kCollected];
  __shared__ std::uint64_t block_begin;
  const std::uint32_t visible = out.counters->visible, first = blockIdx.x * kThreads;
  if (first >= visible) return;
  const unsigned thread = threadIdx.x, warp = thread / kWarp, lane = lane_index();
  for (unsigned i = thread; i < kCounts; i += kThreads) digit_counts[i] = 0;

  Shape shape{};
  std::uint32_t gaussian = 0;
  if (first + thread < visible) {
    gaussian = in.order[first + thread];
    shape = in.shapes[gaussian];
  }
  const BlockSum<std::uint64_t> tiles = sum_of_block(std::uint64_t{shape.tiles});
  if (warp == 0) {
    const std::uint64_t earlier = sum_of_earlier_blocks(out.words, tiles.total);
    if (lane == 0) block_begin = earlier;
    if (lane == 0 && first + kThreads >= visible) {
      out.counters->tile_pairs = earlier + tiles.total;
      out.counters->listed =
          static_cast<std::uint32_t>(min(earlier + tiles.total, std::uint64_t{in.room}));
    }
  }
  __syncthreads();

  const std::uint64_t slot = block_begin + tiles.before;
  const std::uint64_t warp_begin = __shfl_sync(kAllLanes, slot, 0);
  const std::uint64_t warp_tiles =
      __shfl_sync(kAllLanes, slot + shape.tiles, kWarp - 1) - warp_begin;
  const Writer<Key> writer{out, in.room, digit_counts};
  if (warp_tiles <= kCollected) {
    auto at = static_cast<std::uint32_t>(slot - warp_begin);
    const std::uint32_t end = at + shape.tiles;
    if (shape.tiles > 0) {
      for_each_tile<P>(shape.footprint(), in.grid, [&](int tile) {
        if (at == end) return;
        tiles_of_warp[warp][at] = static_cast<Key>(tile);
        lane_of_tile[warp][at] = static_cast<std::uint8_t>(lane);
        ++at;
      });
    }
    __syncwarp();
    const auto count = static_cast<std::uint32_t>(warp_tiles);
    for (std::uint32_t begin = 0; begin < count; begin += kWarp) {
      const std::uint32_t i = begin + lane;
      const unsigned owner = i < count ? lane_of_tile[warp][i] : 0;
      const std::uint32_t owners = __shfl_sync(kAllLanes, gaussian, owner);
      if (i < count) writer.write(warp_begin + i, tiles_of_warp[warp][i], owners);
    }
  } else {
    for (unsigned k = 0; k < kWarp; ++k) {
      const std::uint64_t begin = __shfl_sync(kAllLanes, slot, k);
      const std::uint32_t owner = __shfl_sync(kAllLanes, gaussian, k);
      if (__shfl_sync(kAllLanes, shape.tiles, k) == 0 || begin >= in.room) continue;
      write_together<P>(in.shapes[owner], owner, begin, in.grid, writer);
    }
  }

  __syncthreads();
  for (unsigned i = thread; i < kCounts; i += kThreads) {
    if (digit_counts[i] > 0) atomicAdd(&out.digit_counts[i], digit_counts[i]);
  }
}

template <class P, class Key>
void bin_as(const FrameContext& frame, const FrameSize& size, Visible& visible,
            const DepthOrder& order, Scratch& scratch, TilePairs& pairs) {
  const BinInput in{order.gaussians.data(), visible.shapes.data(), frame.grid, size.pairs};
  const BinOutput<Key> out{pairs.keys_as<Key>(), pairs.gaussians.data(), scratch.counters,
                           scratch.tile_digits, scratch.bin_words};
  launch("bin", list_tiles<P, Key>, std::max(1u, blocks_for(size.gaussians)), frame.stream, in,
         out);
}

}  // namespace

void bin(const FrameContext& frame, const FrameSize& size, Visible& visible,
         const DepthOrder& order, Scratch& scratch, TilePairs& pairs) {
  with_culler(frame.settings.mode, [&]<class P>(P) {
    if (size.narrow()) {
      bin_as<P, std::uint16_t>(frame, size, visible, order, scratch, pairs);
    } else {
      bin_as<P, std::uint32_t>(frame, size, visible, order, scratch, pairs);
    }
  });
}

}  // namespace qs::cuda::fast
