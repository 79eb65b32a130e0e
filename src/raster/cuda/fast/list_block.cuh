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

  static Lists of(const Scratch& scratch) {
    return {scratch.size.grid,   scratch.ranges,   scratch.gaussians, scratch.size.pair_capacity,
            scratch.class_sizes, scratch.schedule, scratch.segments};
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
  if (length > 0) atomicMax(&counters->max_pairs_in_a_tile, length);
  if (last - first > out.segments.longest_uncut)
    out.segments.reserve(tile_index, reserved_segments(last - first));
  return begin;
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
  };

  __device__ ListBlock(SharedArrays arrays, Shared& shared, unsigned size)
      : arrays_(arrays),
        shared_(shared),
        size_(size),
        tile_(threadIdx.x / kWarp % kTiles),
        number_(threadIdx.x / kWarp / kTiles),
        part_(size, number_, kParts) {}

  __device__ void sort(const SortEntry* entries, const std::uint8_t* masks, EntryOrder order) {
    BlockSort<kBlock>(arrays_, entries, order, size_).sort();
    __syncthreads();
    for (unsigned i = threadIdx.x; i < size_; i += kBlock) {
      const unsigned entry = arrays_.order[i];
      arrays_.values[i] = entries[entry].place;
      arrays_.other[i] = masks[entry];
    }
    __syncthreads();
  }

  /// Sets shared.lengths.
  __device__ void count() {
    std::uint32_t length = 0;
#pragma unroll 4
    for (unsigned first = part_.begin; first < part_.end; first += kWarp)
      length += __popc(__ballot_sync(kAllLanes, is_listed(first + lane_index())));
    if (lane_index() == 0) shared_.lengths[number_][tile_] = length;
    __syncthreads();
  }

  /// Requires shared.begins, and shared.lengths if kParts > 1.
  __device__ void write(const Lists& out) {
    std::uint64_t slot = shared_.begins[tile_];
    for (unsigned p = 0; p < number_; ++p) slot += shared_.lengths[p][tile_];
#pragma unroll 4
    for (unsigned first = part_.begin; first < part_.end; first += kWarp) {
      const bool listed = is_listed(first + lane_index());
      const unsigned all = __ballot_sync(kAllLanes, listed);
      const std::uint64_t at = slot + __popc(all & lanes_below());
      if (listed && at < out.capacity) out.gaussians[at] = arrays_.values[first + lane_index()];
      slot += __popc(all);
    }
    __syncthreads();
  }

 private:
  __device__ bool is_listed(unsigned i) const {
    return i < part_.end && (arrays_.other[i] >> tile_ & 1) != 0;
  }

  SharedArrays arrays_;
  Shared& shared_;
  unsigned size_, tile_, number_;
  WarpPart part_;
};

}  // namespace qs::cuda::fast
