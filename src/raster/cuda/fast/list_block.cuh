// SPDX-License-Identifier: MIT
//
// The part of listing that one block does: it sorts the Gaussians of a macro-tile, or of a slice of
// a macro-tile, and writes their part of the lists of its 8 tiles.
#pragma once

#include "raster/cuda/common/block_sort.cuh"
#include "raster/cuda/common/schedule.cuh"
#include "raster/cuda/fast/segments.cuh"
#include "raster/cuda/fast/stages.cuh"

namespace qs::cuda::fast {

// Threads of a block for a usual number of Gaussians and for a larger one, and blocks per
// multiprocessor.
constexpr unsigned kUsualThreads = 256, kUsualBlocks = 6;
constexpr unsigned kLargeThreads = 1024, kLargeBlocks = 1, kMediumBlocks = 2;

/// The memory to which lists are written. A kernel parameter.
struct Lists {
  TileGrid grid;
  ListRange* ranges;
  std::uint32_t* gaussians;
  std::uint32_t capacity;  // of `gaussians`
  std::uint32_t* class_sizes;
  std::uint32_t* scheduled;
  SegmentsView segments;
  SampleFinder samples;

  static Lists of(const Scratch& scratch) {
    const FrameSize& size = scratch.size;
    return {size.grid,           scratch.ranges,
            scratch.gaussians,   size.pair_capacity,
            scratch.class_sizes, scratch.schedule,
            scratch.segments,    {scratch.visible.footprints, size.width, size.height}};
  }
};

/// The tiles of macro-tile `own`.
__device__ inline TileRect tiles_of(const MacroTiles& macro_tiles, std::uint32_t own,
                                    TileGrid grid) {
  const int left = static_cast<int>(own) % macro_tiles.columns * MacroTiles::kColumns;
  const int top = static_cast<int>(own) / macro_tiles.columns * MacroTiles::kRows;
  return {{left, min(left + MacroTiles::kColumns, grid.columns)},
          {top, min(top + MacroTiles::kRows, grid.rows)}};
}

/// Tile `number` of a macro-tile with the tiles `window`, kNoTile if the picture ends before it.
constexpr int kNoTile = -1;
__device__ inline int tile_of(const TileRect& window, unsigned number, TileGrid grid) {
  const int row = window.rows.begin + static_cast<int>(number) / MacroTiles::kColumns;
  const int column = window.columns.begin + static_cast<int>(number) % MacroTiles::kColumns;
  return window.contains(column, row) ? row * grid.columns + column : kNoTile;
}

/// Reserves room for the lists of a macro-tile, whose tile `lane_index()` has `length` entries, and
/// writes its range and schedule. Returns the place of the tile's list. One warp calls it.
__device__ inline std::uint64_t place_list(const Lists& out, const TileRect& window,
                                           std::uint32_t length) {
  FastCounters* const counters = out.segments.counters;
  const unsigned lane = lane_index();
  const int tile = lane < MacroTiles::kTiles ? tile_of(window, lane, out.grid) : kNoTile;
  const std::uint32_t end = inclusive_sum_of_warp(length);
  const std::uint32_t total = __shfl_sync(kAllLanes, end, kWarp - 1);
  std::uint64_t begin = 0;
  if (lane == 0 && total > 0)
    begin = atomicAdd(reinterpret_cast<unsigned long long*>(&counters->tile_pairs),
                      static_cast<unsigned long long>(total));
  begin = __shfl_sync(kAllLanes, begin, 0) + end - length;
  if (tile == kNoTile) return begin;
  const auto tile_index = static_cast<std::uint32_t>(tile);
  const std::uint64_t capacity = out.capacity;
  const auto first = static_cast<std::uint32_t>(min(begin, capacity));
  const auto last = static_cast<std::uint32_t>(min(begin + length, capacity));
  out.ranges[tile] = first < last ? ListRange{first, last} : ListRange{0, 0};
  const unsigned own = length_class(last - first);
  const std::uint32_t place = atomicAdd(&out.class_sizes[own], 1u);
  out.scheduled[own * static_cast<unsigned>(out.grid.count()) + place] = tile_index;
  out.segments.first_segments[tile] = SegmentsView::kUncut;
  if (length > 0) atomicMax(&counters->max_pairs_in_a_tile, length);
  return begin;
}

/// Reserves the segments of a tile's list, if it is cut. The list is at `begin`, and the tile is
/// number `number` of `window`. Requires place_list(). One warp calls it.
__device__ inline void cut_list(const Lists& out, const TileRect& window, unsigned number,
                                std::uint64_t begin, std::uint32_t length, std::uint32_t samples) {
  const CutRule rule = CutRule::of(out.segments);
  // A list that exceeds the buffers is not cut, because its frame is drawn again.
  if (!rule.cuts(samples) || begin + length > out.capacity) return;
  if (lane_index() == 0) atomicMax(&out.segments.counters->longest_samples, samples);
  reserve_segments(out.segments, static_cast<std::uint32_t>(tile_of(window, number, out.grid)),
                   static_cast<std::uint32_t>(begin), samples, rule.each_of(samples));
}

/// Counts of 16 things, 8 bits each.
struct PackedCounts {
  static constexpr unsigned kWords = 4, kEach = 4;  // counts of a word
  std::uint32_t words[kWords] = {};

  /// Adds 1 to the counts whose bits are set.
  __device__ void add(MarkedTiles bits) {
    constexpr std::uint32_t kSpread = 0x00204081, kLowBits = 0x01010101;  // a bit per byte
#pragma unroll
    for (unsigned w = 0; w < kWords; ++w) words[w] += (bits >> kEach * w & 15) * kSpread & kLowBits;
  }
  __device__ std::uint32_t count(unsigned i) const {
    return words[i / kEach] >> 8 * (i % kEach) & 255;
  }
};

/// The kBlock threads of a block list `size` Gaussians. They call all functions together, in this
/// order. Every warp writes a part of the Gaussians to the lists of all tiles.
template <unsigned kBlock>
class ListBlock {
 public:
  static constexpr unsigned kTiles = MacroTiles::kTiles;
  static constexpr unsigned kParts = kBlock / kWarp;
  static_assert(kTiles <= kParts && kParts <= kWarp);

  /// Per tile: entries of lists, or their samples.
  struct Counts {
    std::uint32_t before[kParts][kTiles];  ///< in front of each warp's part
    std::uint32_t total[kTiles];
  };
  struct Shared {
    std::uint64_t begins[kTiles];  ///< where the tiles' lists begin, or the block's part of each
    std::uint32_t sample_begins[kTiles];  ///< samples of the lists in front of the block's part
    Counts entries, samples;
  };

  __device__ ListBlock(SharedArrays arrays, Shared& shared, unsigned size)
      : arrays_(arrays),
        shared_(shared),
        size_(size),
        warp_(threadIdx.x / kWarp),
        part_(size, warp_, kParts) {}

  /// `masks` has the tiles of the entries, or MarkedTiles.
  template <class Mask>
  __device__ void sort(const SortEntry* entries, const Mask* masks, EntryOrder order) {
    BlockSort<kBlock>(arrays_, entries, order, size_).sort();
    __syncthreads();
#pragma unroll 4
    for (unsigned i = threadIdx.x; i < size_; i += kBlock) {
      const unsigned entry = arrays_.order[i];
      arrays_.values[i] = entries[entry].place;
      arrays_.other[i] = masks[entry];
    }
    __syncthreads();
  }

  /// Marks the samples. They are collected first, so that no thread waits for another's.
  __device__ void mark(const SampleFinder& samples, const CutRule& rule, const TileRect& window) {
    __shared__ std::uint32_t found;
    if (threadIdx.x == 0) found = 0;
    __syncthreads();
    for (unsigned i = threadIdx.x; i - lane_index() < size_; i += kBlock) {
      const bool may_be = i < size_ && rule.may_be_sample(arrays_.values[i]);
      const std::uint32_t slot = reserve_slot(may_be, &found);
      if (may_be) arrays_.order[slot] = static_cast<std::uint16_t>(i);
    }
    __syncthreads();
    for (unsigned k = threadIdx.x; k < found; k += kBlock) {
      const unsigned i = arrays_.order[k];
      arrays_.other[i] = samples.marked(arrays_.values[i], arrays_.other[i], window);
    }
    __syncthreads();
  }

  /// Sets shared.entries.
  __device__ void count() { count_bits(shared_.entries, 0); }
  /// Sets shared.samples.
  __device__ void count_samples() { count_bits(shared_.samples, kSampleShift); }

  /// Cuts the lists of the tiles of `window`. Requires shared.begins, entries and samples.
  __device__ void cut(const Lists& out, const TileRect& window) {
    if (warp_ < kTiles)
      cut_list(out, window, warp_, shared_.begins[warp_], shared_.entries.total[warp_],
               shared_.samples.total[warp_]);
    __syncthreads();
  }

  /// Writes the lists of the tiles of `window`, and where their segments begin if some are marked.
  /// Requires shared.begins, sample_begins, entries and, if is_marked, samples.
  __device__ void write(const Lists& out, const TileRect& window, bool is_marked) {
    const unsigned own = lane_index() % kTiles;  // a lane keeps the list of a tile
    std::uint32_t slot = static_cast<std::uint32_t>(
        min(shared_.begins[own] + shared_.entries.before[warp_][own], std::uint64_t{out.capacity}));
    Borders borders;
    if (is_marked && lane_index() < kTiles)
      borders = Borders(out, window, own,
                        shared_.sample_begins[own] + shared_.samples.before[warp_][own]);
    for (unsigned first = part_.begin; first < part_.end; first += kWarp) {
      const unsigned i = first + lane_index();
      const unsigned mask = i < part_.end ? arrays_.other[i] : 0;
      const std::uint32_t value = i < part_.end ? arrays_.values[i] : 0;
      unsigned listed = 0;  // the lanes whose entries the lane's tile lists
#pragma unroll
      for (unsigned tile = 0; tile < kTiles; ++tile) {
        const bool lists = (mask >> tile & 1) != 0;
        const unsigned all = __ballot_sync(kAllLanes, lists);
        const std::uint32_t at = __shfl_sync(kAllLanes, slot, tile) + __popc(all & lanes_below());
        if (lists && at < out.capacity) out.gaussians[at] = value;
        if (own == tile) listed = all;
      }
      if (is_marked) borders.add(mask >> kSampleShift, listed, slot);
      slot += __popc(listed);
    }
    __syncthreads();
  }

 private:
  /// Writes where the segments of a tile's list begin. Each of the first kTiles lanes has a tile's.
  struct Borders {
    Segment* next = nullptr;    ///< the next segment that begins; null: the list is not cut
    std::uint32_t each = 0;     ///< samples in a segment
    std::uint32_t missing = 0;  ///< samples until the next segment begins

    __device__ Borders() = default;
    /// `rank`: samples of the list in front of the warp's part.
    __device__ Borders(const Lists& out, const TileRect& window, unsigned tile,
                       std::uint32_t rank) {
      const int own = tile_of(window, tile, out.grid);
      if (own == kNoTile) return;
      const std::uint32_t first = out.segments.first_segments[own];
      if (first == SegmentsView::kUncut) return;
      next = out.segments.segments + first;
      each = next->each;
      const std::uint32_t number = max((rank + each - 1) / each, 1u);  // of the next segment
      missing = number * each - rank;
      next += number;
    }

    /// Adds an entry of each lane, which is a sample of the tiles `samples_of`. `listed`: the lanes
    /// whose entries the tile lists, from `slot` on. All lanes call it together.
    __device__ void add(unsigned samples_of, unsigned listed, std::uint32_t slot) {
      for (unsigned all = __ballot_sync(kAllLanes, samples_of != 0); all != 0; all &= all - 1) {
        const unsigned lane = static_cast<unsigned>(__ffs(static_cast<int>(all))) - 1;
        const unsigned tiles = __shfl_sync(kAllLanes, samples_of, lane);
        if (next == nullptr || (tiles >> lane_index() & 1) == 0) continue;
        if (missing > 0) {
          --missing;
          continue;
        }
        next->begin = slot + __popc(listed & ((1u << lane) - 1));
        ++next;
        missing = each - 1;
      }
    }
  };

  /// Counts the bits `shift` to `shift` + 7 of the masks.
  __device__ void count_bits(Counts& counts, unsigned shift) {
    PackedCounts own;
#pragma unroll 4
    for (unsigned i = part_.begin + lane_index(); i < part_.end; i += kWarp)
      own.add(static_cast<MarkedTiles>(arrays_.other[i] >> shift & (1u << kTiles) - 1));
#pragma unroll
    for (unsigned tile = 0; tile < kTiles; ++tile) {
      const std::uint32_t sum = inclusive_sum_of_warp(own.count(tile));
      if (lane_index() == kWarp - 1) counts.before[warp_][tile] = sum;
    }
    __syncthreads();
    if (warp_ < kTiles) {
      const std::uint32_t part = lane_index() < kParts ? counts.before[lane_index()][warp_] : 0;
      const std::uint32_t end = inclusive_sum_of_warp(part);
      if (lane_index() < kParts) counts.before[lane_index()][warp_] = end - part;
      if (lane_index() == kWarp - 1) counts.total[warp_] = end;
    }
    __syncthreads();
  }

  SharedArrays arrays_;
  Shared& shared_;
  unsigned size_, warp_;
  WarpPart part_;
};

}  // namespace qs::cuda::fast
