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

/// Reserves room for the lists of a macro-tile, whose tile `lane_index()` has `length` entries, and
/// writes its range and schedule. Returns the place of the tile's list. One warp calls it.
__device__ inline std::uint64_t place_list(const Lists& out, const TileRect& window,
                                           std::uint32_t length) {
  FastCounters* const counters = out.segments.counters;
  const unsigned lane = lane_index();
  const int row = window.rows.begin + static_cast<int>(lane) / MacroTiles::kColumns;
  const int column = window.columns.begin + static_cast<int>(lane) % MacroTiles::kColumns;
  const bool exists = lane < MacroTiles::kTiles && window.contains(column, row);
  const std::uint32_t end = inclusive_sum_of_warp(length);
  const std::uint32_t total = __shfl_sync(kAllLanes, end, kWarp - 1);
  std::uint64_t begin = 0;
  if (lane == 0 && total > 0)
    begin = atomicAdd(reinterpret_cast<unsigned long long*>(&counters->tile_pairs),
                      static_cast<unsigned long long>(total));
  begin = __shfl_sync(kAllLanes, begin, 0) + end - length;
  if (!exists) return begin;
  const int tile = row * out.grid.columns + column;
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
  const int row = window.rows.begin + static_cast<int>(number) / MacroTiles::kColumns;
  const int column = window.columns.begin + static_cast<int>(number) % MacroTiles::kColumns;
  if (lane_index() == 0) atomicMax(&out.segments.counters->longest_samples, samples);
  reserve_segments(out.segments, static_cast<std::uint32_t>(row * out.grid.columns + column),
                   static_cast<std::uint32_t>(begin), samples, rule.each_of(samples));
}

/// The kBlock threads of a block list `size` Gaussians. They call all functions together, in this
/// order. Several warps write the list of a tile, each a part of it.
template <unsigned kBlock>
class ListBlock {
 public:
  static constexpr unsigned kTiles = MacroTiles::kTiles;
  static constexpr unsigned kParts = kBlock / kWarp / kTiles;

  struct Shared {
    std::uint64_t begins[kTiles];  ///< where the tiles' lists begin, or the block's part of each
    std::uint32_t lengths[kParts][kTiles];
    std::uint32_t sample_begins[kTiles];  ///< samples of the lists in front of the block's part
    std::uint32_t samples[kParts][kTiles];
  };

  __device__ ListBlock(SharedArrays arrays, Shared& shared, unsigned size)
      : arrays_(arrays),
        shared_(shared),
        size_(size),
        tile_(threadIdx.x / kWarp % kTiles),
        number_(threadIdx.x / kWarp / kTiles),
        part_(size, number_, kParts) {}

  /// `masks` has the tiles of the entries, or MarkedTiles.
  template <class Mask>
  __device__ void sort(const SortEntry* entries, const Mask* masks, EntryOrder order) {
    BlockSort<kBlock>(arrays_, entries, order, size_).sort();
    __syncthreads();
    for (unsigned i = threadIdx.x; i < size_; i += kBlock) {
      const unsigned entry = arrays_.order[i];
      arrays_.values[i] = entries[entry].place;
      arrays_.other[i] = masks[entry];
    }
    __syncthreads();
  }

  /// Marks the samples. They are collected first, so that no thread waits for another's.
  __device__ void mark(const SampleFinder& samples, const TileRect& window) {
    __shared__ std::uint32_t found;
    if (threadIdx.x == 0) found = 0;
    __syncthreads();
    for (unsigned i = threadIdx.x; i - lane_index() < size_; i += kBlock) {
      const bool may_be = i < size_ && may_be_sample(arrays_.values[i]);
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

  /// Sets shared.lengths.
  __device__ void count() {
    count_entries(shared_.lengths, [this](unsigned i) { return is_listed(i); });
  }
  /// Sets shared.samples.
  __device__ void count_samples() {
    count_entries(shared_.samples, [this](unsigned i) { return is_sample(i); });
  }

  /// Cuts the lists of the tiles of `window`. Requires shared.begins, lengths and samples.
  __device__ void cut(const Lists& out, const TileRect& window) {
    std::uint32_t length = 0, samples = 0;
    for (unsigned p = 0; p < kParts; ++p) {
      length += shared_.lengths[p][tile_];
      samples += shared_.samples[p][tile_];
    }
    if (number_ == 0) cut_list(out, window, tile_, shared_.begins[tile_], length, samples);
    __syncthreads();
  }

  /// Writes the lists of the tiles of `window`, and where their segments begin if some are marked.
  /// Requires shared.begins and sample_begins, and shared.lengths and samples if kParts > 1.
  __device__ void write(const Lists& out, const TileRect& window, bool is_marked) {
    std::uint64_t slot = shared_.begins[tile_];
    std::uint32_t rank = shared_.sample_begins[tile_];
    for (unsigned p = 0; p < number_; ++p) {
      slot += shared_.lengths[p][tile_];
      rank += shared_.samples[p][tile_];
    }
    const std::uint32_t first_segment =
        is_marked ? first_segment_of(out, window) : SegmentsView::kUncut;
    if (first_segment == SegmentsView::kUncut) {
      write_entries(out, slot, [](unsigned, std::uint64_t) {});
    } else {
      Segment* const segments = out.segments.segments + first_segment;
      const std::uint32_t each = segments->each;
      write_entries(out, slot, [&](unsigned i, std::uint64_t at) {
        const bool sample = is_sample(i);
        const unsigned all = __ballot_sync(kAllLanes, sample);
        const std::uint32_t own = rank + __popc(all & lanes_below());
        if (sample && own > 0 && own % each == 0)
          segments[own / each].begin = static_cast<std::uint32_t>(at);
        rank += __popc(all);
      });
    }
    __syncthreads();
  }

 private:
  template <class IsCounted>
  __device__ void count_entries(std::uint32_t (&counts)[kParts][kTiles],
                                const IsCounted& is_counted) {
    std::uint32_t count = 0;
#pragma unroll 4
    for (unsigned first = part_.begin; first < part_.end; first += kWarp)
      count += __popc(__ballot_sync(kAllLanes, is_counted(first + lane_index())));
    if (lane_index() == 0) counts[number_][tile_] = count;
    __syncthreads();
  }

  __device__ bool is_listed(unsigned i) const {
    return i < part_.end && (arrays_.other[i] >> tile_ & 1) != 0;
  }
  __device__ bool is_sample(unsigned i) const {
    return i < part_.end && (arrays_.other[i] >> (kSampleShift + tile_) & 1) != 0;
  }

  __device__ std::uint32_t first_segment_of(const Lists& out, const TileRect& window) const {
    const int row = window.rows.begin + static_cast<int>(tile_) / MacroTiles::kColumns;
    const int column = window.columns.begin + static_cast<int>(tile_) % MacroTiles::kColumns;
    if (!window.contains(column, row)) return SegmentsView::kUncut;
    return out.segments.first_segments[row * out.grid.columns + column];
  }

  /// Calls visit(i, where) for all entries i of the warp's part; `where` is the place of an entry
  /// that the tile lists. All lanes call it together.
  template <class Visit>
  __device__ void write_entries(const Lists& out, std::uint64_t slot, const Visit& visit) {
#pragma unroll 4
    for (unsigned first = part_.begin; first < part_.end; first += kWarp) {
      const unsigned i = first + lane_index();
      const bool listed = is_listed(i);
      const unsigned all = __ballot_sync(kAllLanes, listed);
      const std::uint64_t at = slot + __popc(all & lanes_below());
      if (listed && at < out.capacity) out.gaussians[at] = arrays_.values[i];
      visit(i, at);
      slot += __popc(all);
    }
  }

  SharedArrays arrays_;
  Shared& shared_;
  unsigned size_, tile_, number_;
  WarpPart part_;
};

}  // namespace qs::cuda::fast
