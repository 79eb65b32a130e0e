// SPDX-License-Identifier: MIT
//
// How a block sorts the Gaussians of a macro-tile, or of a slice of one, and writes their part of
// the lists of its 8 tiles.
#pragma once

#include "raster/cuda/fast/list.cuh"
#include "raster/cuda/fast/macro_sort.cuh"
#include "raster/cuda/fast/schedule.cuh"
#include "raster/cuda/fast/segments.cuh"

namespace qs::cuda::fast {

// Threads of a block for a usual number of Gaussians and for a large one, and blocks per
// multiprocessor.
constexpr unsigned kUsualThreads = 256, kUsualBlocks = 6;
constexpr unsigned kLargeThreads = 1024, kLargeBlocks = 1;

/// Where lists are written. A kernel parameter.
struct Lists {
  TileGrid grid;
  ListRange* ranges;
  std::uint32_t* gaussians;
  std::uint32_t capacity;  // of `gaussians`
  std::uint32_t* class_sizes;
  std::uint32_t* scheduled;
  SegmentsView segments;

  static Lists of(const FrameContext& frame, const FrameSize& size, const Scratch& scratch,
                  TilePairs& pairs) {
    return {frame.grid,          scratch.ranges,   pairs.gaussians.data(), size.pair_capacity,
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
  Counters* const counters = out.segments.counters;
  const unsigned lane = lane_index();
  const int row = window.rows.begin + static_cast<int>(lane) / MacroTiles::kColumns;
  const int column = window.columns.begin + static_cast<int>(lane) % MacroTiles::kColumns;
  const bool exists = lane < MacroTiles::kTiles && window.contains(column, row);
  const std::uint32_t end = inclusive_sum_of_warp(length);
  const std::uint32_t total = __shfl_sync(kAllLanes, end, kWarp - 1);
  std::uint64_t begin = 0;
  if (lane == 0 && total > 0) {
    begin = atomicAdd(reinterpret_cast<unsigned long long*>(&counters->tile_pairs),
                      static_cast<unsigned long long>(total));
  }
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
  if (last - first > kLongList) out.segments.reserve(tile_index, segment_count(last - first));
  return begin;
}

/// Sorts `size` entries and writes their part of the lists. begin_of(n) is called by one warp, whose
/// lane t < kTiles passes the number n of entries of tile t and gets the place of the first one.
/// The kBlock threads of a block call it together.
template <unsigned kBlock, class BeginOf>
__device__ void list_entries(const MacroEntry* entries, const std::uint8_t* masks, unsigned size,
                             SharedArrays arrays, const Lists& out, const BeginOf& begin_of) {
  constexpr unsigned kTiles = MacroTiles::kTiles, kParts = kBlock / kWarp / kTiles;
  __shared__ std::uint32_t lengths[kParts][kTiles];
  __shared__ std::uint64_t begins[kTiles];
  MacroSort<kBlock>(arrays, entries, size).sort();
  __syncthreads();
  for (unsigned i = threadIdx.x; i < size; i += kBlock) {
    const unsigned entry = arrays.order[i];
    arrays.values[i] = entries[entry].gaussian;
    arrays.other[i] = masks[entry];
  }
  __syncthreads();

  const unsigned warp = threadIdx.x / kWarp, tile = warp % kTiles, number = warp / kTiles;
  const WarpPart part(size, number, kParts);
  const auto listed_at = [&](unsigned i) {
    return i < part.end && (arrays.other[i] >> tile & 1) != 0;
  };
  std::uint32_t length = 0;
#pragma unroll 4
  for (unsigned first = part.begin; first < part.end; first += kWarp) {
    length += __popc(__ballot_sync(kAllLanes, listed_at(first + lane_index())));
  }
  if (lane_index() == 0) lengths[number][tile] = length;
  __syncthreads();
  if (warp == 0) {
    std::uint32_t whole = 0;
    for (unsigned p = 0; p < kParts && lane_index() < kTiles; ++p) {
      whole += lengths[p][lane_index()];
    }
    const std::uint64_t begin = begin_of(whole);
    if (lane_index() < kTiles) begins[lane_index()] = begin;
  }
  __syncthreads();
  std::uint64_t slot = begins[tile];
  for (unsigned p = 0; p < number; ++p) slot += lengths[p][tile];
#pragma unroll 4
  for (unsigned first = part.begin; first < part.end; first += kWarp) {
    const unsigned i = first + lane_index();
    const bool listed = listed_at(i);
    const unsigned all = __ballot_sync(kAllLanes, listed);
    const std::uint64_t at = slot + __popc(all & lanes_below());
    if (listed && at < out.capacity) out.gaussians[at] = arrays.values[i];
    slot += __popc(all);
  }
  __syncthreads();
}

}  // namespace qs::cuda::fast
