// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/bin.cuh"

namespace qs::cuda::fast {
namespace {

struct BinInput {
  const std::uint32_t* order;        // where the depth sort's last pass rested, else
  const std::uint32_t* other_order;  // here
  const std::uint32_t* last_digits;  // of the depth keys
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

/// Writes pairs and counts their digits for the block.
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

/// The last of kThreads ascending numbers that is not above `item`; the first is not.
__device__ unsigned owner_of(const std::uint32_t* begins, std::uint32_t item) {
  unsigned owner = 0;
  for (unsigned step = kThreads / 2; step > 0; step /= 2) {
    if (begins[owner + step] <= item) owner += step;
  }
  return owner;
}

/// The runs of tiles that a block's threads have found, and where their pairs begin.
struct Runs {
  int tile[kThreads], step[kThreads];
  std::uint32_t gaussian[kThreads], begin[kThreads];
};

/// The Gaussians of a block, whose pairs lie side by side from `slot` on. First every thread takes
/// a line of tiles of whichever Gaussian owns it and finds its run, then every thread takes a pair
/// of whichever run owns it: neither large Gaussians nor long runs keep one thread busy.
template <class P, class Key>
__device__ void write_lines(const Shape& own_shape, std::uint32_t own_gaussian, std::uint64_t slot,
                            const BinInput& in, const Writer<Key>& writer) {
  __shared__ Shape shapes[kThreads];
  __shared__ std::uint32_t gaussians[kThreads], first_lines[kThreads];
  __shared__ Runs runs;
  const unsigned thread = threadIdx.x;
  const BlockSum<std::uint32_t> lines = sum_of_block<kThreads>(own_shape.lines);
  shapes[thread] = own_shape;
  gaussians[thread] = own_gaussian;
  first_lines[thread] = lines.before;
  for (std::uint32_t first = 0; first < lines.total && slot < in.room; first += kThreads) {
    __syncthreads();
    const std::uint32_t line = first + thread;
    int size = 0;
    if (line < lines.total) {
      const unsigned owner = owner_of(first_lines, line);
      const auto walk = P::walk(shapes[owner].footprint(), in.grid);
      const int at = walk.lines.begin + static_cast<int>(line - first_lines[owner]);
      const Span span = walk.span(at);
      size = span.size();
      const int columns = in.grid.columns;
      runs.tile[thread] = walk.by_rows ? at * columns + span.begin : span.begin * columns + at;
      runs.step[thread] = walk.by_rows ? 1 : columns;
      runs.gaussian[thread] = gaussians[owner];
    }
    const BlockSum<std::uint32_t> pairs = sum_of_block<kThreads>(static_cast<std::uint32_t>(size));
    runs.begin[thread] = pairs.before;
    __syncthreads();
    const std::uint64_t room = in.room - slot;
    const auto end = static_cast<std::uint32_t>(min(std::uint64_t{pairs.total}, room));
    for (std::uint32_t i = thread; i < end; i += kThreads) {
      const unsigned run = owner_of(runs.begin, i);
      const int tile = runs.tile[run] + static_cast<int>(i - runs.begin[run]) * runs.step[run];
      writer.write(slot + i, tile, runs.gaussian[run]);
    }
    slot += pairs.total;
  }
}

/// A block per kThreads visible Gaussians, front to back.
template <class P, class Key>
__global__ void __launch_bounds__(kThreads) list_tiles(BinInput in, BinOutput<Key> out) {
  __shared__ std::uint32_t digit_counts[Writer<Key>::kCounts];
  __shared__ std::uint64_t block_begin;
  const std::uint32_t visible = out.counters->visible, first = blockIdx.x * kThreads;
  if (first >= visible) return;
  const unsigned thread = threadIdx.x;
  for (unsigned i = thread; i < Writer<Key>::kCounts; i += kThreads) digit_counts[i] = 0;

  Shape shape{};
  std::uint32_t gaussian = 0;
  if (first + thread < visible) {
    const std::uint32_t* order = in.last_digits[0] == visible ? in.order : in.other_order;
    gaussian = order[first + thread];
    shape = in.shapes[gaussian];
  }
  const BlockSum<std::uint64_t> tiles = sum_of_block<kThreads>(std::uint64_t{shape.tiles});
  if (thread < kWarp) {
    const std::uint64_t earlier = sum_of_earlier_blocks(out.words, tiles.total);
    if (thread == 0) block_begin = earlier;
    if (thread == 0 && first + kThreads >= visible) {
      const std::uint64_t total = earlier + tiles.total;
      out.counters->tile_pairs = total;
      out.counters->listed = static_cast<std::uint32_t>(min(total, std::uint64_t{in.room}));
    }
  }
  __syncthreads();

  const Writer<Key> writer{out, digit_counts};
  if constexpr (requires { P::walk(shape.footprint(), in.grid); }) {
    write_lines<P>(shape, gaussian, block_begin, in, writer);
  } else if (shape.tiles > 0) {
    std::uint64_t slot = block_begin + tiles.before;
    const std::uint64_t end = min(slot + shape.tiles, std::uint64_t{in.room});
    P::for_each_tile(shape.footprint(), in.grid, [&](int tile) {
      if (slot < end) writer.write(slot++, tile, gaussian);
    });
  }

  __syncthreads();
  for (unsigned i = thread; i < Writer<Key>::kCounts; i += kThreads) {
    if (digit_counts[i] > 0) atomicAdd(&out.digit_counts[i], digit_counts[i]);
  }
}

template <class P, class Key>
void bin_as(const FrameContext& frame, const FrameSize& size, Visible& visible,
            const DepthOrder& order, Scratch& scratch, TilePairs& pairs) {
  constexpr int kLastPass = Radix<std::uint32_t>::kPasses - 1;
  const BinInput in{order.gaussians.data(),
                    order.other_gaussians.data(),
                    scratch.depth_digits + kLastPass * kBins<std::uint32_t>,
                    visible.shapes.data(),
                    frame.grid,
                    size.pairs};
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
