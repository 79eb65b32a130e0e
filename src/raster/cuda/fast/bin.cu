// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/bin.cuh"

namespace qs::cuda::fast {
namespace {

constexpr unsigned kBinBlocks = 3;              // per multiprocessor, to hide latency
constexpr unsigned kGaussians = kThreads;       // per block
constexpr unsigned kBinThreads = 2 * kThreads;  // per block; they share the lines and pairs

struct BinInput {
  const std::uint32_t* order;
  const PackedFootprint* footprints;
  TileGrid grid;
  std::uint32_t capacity;  // pairs that fit into BinOutput
};

template <class Key>
struct BinOutput {
  Key* keys;
  std::uint32_t* gaussians;
  Counters* counters;
  std::uint32_t* digit_counts;
  volatile std::uint64_t* words;  // look-back
};

/// Writes pairs and counts the digits of their keys per block.
template <class Key>
struct Writer {
  static constexpr int kPasses = Radix<Key>::kPasses;
  static constexpr unsigned kCounts = kPasses * kBins<Key>;
  const BinOutput<Key>& out;
  std::uint32_t* digit_counts;  // shared, kCounts

  __device__ void write(std::uint64_t slot, int tile, std::uint32_t gaussian) const {
    const auto key = static_cast<Key>(tile);
    out.keys[slot] = key;
    out.gaussians[slot] = gaussian;
    for (int pass = 0; pass < kPasses; ++pass) {
      atomicAdd(&digit_counts[pass * kBins<Key> + digit_of(key, pass)], 1u);
    }
  }
};

/// Index of the last of the ascending `begins` that is <= `item`. Requires begins[0] <= item.
template <unsigned kCount>
__device__ unsigned owner_of(const std::uint32_t (&begins)[kCount], std::uint32_t item) {
  unsigned owner = 0;
  for (unsigned step = kCount / 2; step > 0; step /= 2) {
    if (begins[owner + step] <= item) owner += step;
  }
  return owner;
}

/// The runs of tiles that a block's threads have found; `begin` is the first pair of each run.
struct Runs {
  int tile[kBinThreads], step[kBinThreads];
  std::uint32_t gaussian[kBinThreads], begin[kBinThreads];
};

/// Writes the pairs of a block's Gaussians contiguously from `slot` on. First every thread finds
/// the run of one line of tiles, then every thread writes single pairs of the runs. A binary search
/// finds the owner of a line or pair, so large Gaussians and long runs are shared by all threads.
template <class P, class Key>
__device__ void write_lines(const PackedFootprint& own, std::uint32_t own_gaussian,
                            std::uint64_t slot, const BinInput& in, const Writer<Key>& writer) {
  __shared__ PackedFootprint footprints[kGaussians];
  __shared__ std::uint32_t gaussians[kGaussians], first_lines[kGaussians];
  __shared__ Runs runs;
  const unsigned thread = threadIdx.x;
  const BlockSum<std::uint32_t> lines = sum_of_block<kBinThreads>(own.lines);
  if (thread < kGaussians) {
    footprints[thread] = own;
    gaussians[thread] = own_gaussian;
    first_lines[thread] = lines.before;
  }
  for (std::uint32_t first = 0; first < lines.total && slot < in.capacity; first += kBinThreads) {
    __syncthreads();
    const std::uint32_t line = first + thread;
    int size = 0;
    if (line < lines.total) {
      const unsigned owner = owner_of(first_lines, line);
      const auto walk = P::walk(footprints[owner].footprint(), in.grid);
      const int at = walk.lines.begin + static_cast<int>(line - first_lines[owner]);
      const Span span = walk.span(at);
      size = span.size();
      const int columns = in.grid.columns;
      runs.tile[thread] = walk.by_rows ? at * columns + span.begin : span.begin * columns + at;
      runs.step[thread] = walk.by_rows ? 1 : columns;
      runs.gaussian[thread] = gaussians[owner];
    }
    const BlockSum<std::uint32_t> pairs =
        sum_of_block<kBinThreads>(static_cast<std::uint32_t>(size));
    runs.begin[thread] = pairs.before;
    __syncthreads();
    const std::uint64_t left = in.capacity - slot;
    const auto end = static_cast<std::uint32_t>(min(std::uint64_t{pairs.total}, left));
#pragma unroll 4
    for (std::uint32_t i = thread; i < end; i += kBinThreads) {
      const unsigned run = owner_of(runs.begin, i);
      const int tile = runs.tile[run] + static_cast<int>(i - runs.begin[run]) * runs.step[run];
      writer.write(slot + i, tile, runs.gaussian[run]);
    }
    slot += pairs.total;
  }
}

/// One block per kGaussians visible Gaussians in front-to-back order.
template <class P, class Key>
__global__ void __launch_bounds__(kBinThreads, kBinBlocks)
    list_tiles(BinInput in, BinOutput<Key> out) {
  __shared__ std::uint32_t digit_counts[Writer<Key>::kCounts];
  __shared__ std::uint64_t block_begin;
  const std::uint32_t visible = out.counters->visible, first = blockIdx.x * kGaussians;
  if (first >= visible) return;
  const unsigned thread = threadIdx.x;
  for (unsigned i = thread; i < Writer<Key>::kCounts; i += kBinThreads) digit_counts[i] = 0;

  PackedFootprint footprint{};
  std::uint32_t gaussian = 0;
  if (thread < kGaussians && first + thread < visible) {
    gaussian = in.order[first + thread];
    footprint = in.footprints[gaussian];
  }
  const BlockSum<std::uint64_t> tiles = sum_of_block<kBinThreads>(std::uint64_t{footprint.tiles});
  if (thread < kWarp) {
    const std::uint64_t earlier = sum_of_earlier_blocks(out.words, tiles.total);
    if (thread == 0) block_begin = earlier;
    if (thread == 0 && first + kGaussians >= visible) {
      const std::uint64_t total = earlier + tiles.total;
      out.counters->tile_pairs = total;
      out.counters->listed = static_cast<std::uint32_t>(min(total, std::uint64_t{in.capacity}));
    }
  }
  __syncthreads();

  const Writer<Key> writer{out, digit_counts};
  if constexpr (kWalks<P>) {
    write_lines<P>(footprint, gaussian, block_begin, in, writer);
  } else if (footprint.tiles > 0) {
    std::uint64_t slot = block_begin + tiles.before;
    const std::uint64_t end = min(slot + footprint.tiles, std::uint64_t{in.capacity});
    for_each_tile<P>(footprint.footprint(), in.grid, [&](int tile) {
      if (slot < end) writer.write(slot++, tile, gaussian);
    });
  }

  __syncthreads();
  for (unsigned i = thread; i < Writer<Key>::kCounts; i += kBinThreads) {
    if (digit_counts[i] > 0) atomicAdd(&out.digit_counts[i], digit_counts[i]);
  }
}

template <class P, class Key>
void bin_as(const FrameContext& frame, const FrameSize& size, Visible& visible,
            const DepthOrder& order, Scratch& scratch, TilePairs& pairs) {
  const BinInput in{order.gaussians.data(), visible.footprints.data(), frame.grid,
                    size.pair_capacity};
  const BinOutput<Key> out{pairs.keys_as<Key>(), pairs.gaussians.data(), scratch.counters,
                           scratch.tile_digits, scratch.bin_words};
  launch("bin", list_tiles<P, Key>, Blocks(std::max(1u, blocks_for(size.gaussians)), kBinThreads),
         frame.stream, in, out);
}

}  // namespace

void bin(const FrameContext& frame, const FrameSize& size, Visible& visible,
         const DepthOrder& order, Scratch& scratch, TilePairs& pairs) {
  with_culler(frame.settings.mode, [&]<class P>(P) {
    if (size.uses_16_bit_keys()) {
      bin_as<P, std::uint16_t>(frame, size, visible, order, scratch, pairs);
    } else {
      bin_as<P, std::uint32_t>(frame, size, visible, order, scratch, pairs);
    }
  });
}

}  // namespace qs::cuda::fast
