// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/dynamic_shared.cuh"
#include "raster/cuda/fast/macro_sort.cuh"
#include "raster/cuda/fast/macro_tiles.cuh"
#include "raster/cuda/fast/schedule.cuh"
#include "raster/cuda/fast/segments.cuh"

namespace qs::cuda::fast {
namespace {

// Threads of a block for usual macro-tiles and for full ones, and blocks per multiprocessor.
constexpr unsigned kUsualThreads = 256, kUsualBlocks = 6;
constexpr unsigned kFullThreads = 1024, kFullBlocks = 1;
constexpr unsigned kFullCount = 132;  // blocks for full macro-tiles

struct Lists {
  TileGrid grid;
  KeyRange* ranges;
  std::uint32_t* gaussians;
  std::uint32_t capacity;  // of `gaussians`
  std::uint32_t* class_sizes;
  std::uint32_t* scheduled;
  SegmentsView segments;
};

/// Reserves room for the lists of a macro-tile, whose tile `lane_index()` has `length` entries, and
/// writes its range and schedule. Returns the place of the tile's list. One warp calls it.
__device__ std::uint64_t place_list(const Lists& out, const TileRect& window,
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
  out.ranges[tile] = first < last ? KeyRange{~first, last} : KeyRange{0, 0};
  if (out.class_sizes != nullptr) {
    const unsigned own = length_class(last - first);
    const std::uint32_t place = atomicAdd(&out.class_sizes[own], 1u);
    out.scheduled[own * static_cast<unsigned>(out.grid.count()) + place] = tile_index;
  }
  if (length > 0) atomicMax(&counters->max_pairs_in_a_tile, length);
  if (last - first > kLongList) out.segments.reserve(tile_index, segment_count(last - first));
  return begin;
}

/// Lists one macro-tile. The kBlock threads of a block call it together.
template <unsigned kBlock>
__device__ void list_macro_tile(std::uint32_t own, unsigned size, SharedArrays arrays,
                                const MacroTiles& macro_tiles, const Lists& out) {
  constexpr unsigned kTiles = MacroTiles::kTiles, kParts = kBlock / kWarp / kTiles;
  __shared__ std::uint32_t lengths[kParts][kTiles];
  __shared__ std::uint64_t begins[kTiles];
  const int left = static_cast<int>(own) % macro_tiles.columns * MacroTiles::kColumns;
  const int top = static_cast<int>(own) / macro_tiles.columns * MacroTiles::kRows;
  const TileRect window{{left, min(left + MacroTiles::kColumns, out.grid.columns)},
                        {top, min(top + MacroTiles::kRows, out.grid.rows)}};
  const std::size_t first_entry = std::size_t{own} * macro_tiles.capacity;
  const MacroEntry* const entries = macro_tiles.entries + first_entry;
  MacroSort<kBlock>(arrays, entries, size).sort();
  __syncthreads();
  for (unsigned i = threadIdx.x; i < size; i += kBlock) {
    const unsigned entry = arrays.order[i];
    arrays.values[i] = entries[entry].gaussian;
    arrays.other[i] = macro_tiles.masks[first_entry + entry];
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
    const std::uint64_t begin = place_list(out, window, whole);
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

/// A block per macro-tile with less than MacroTiles::kUsual Gaussians, and per tile that exceeds
/// the capacity if list_full() does not run.
__global__ void __launch_bounds__(kUsualThreads, kUsualBlocks)
    list_usual(MacroTiles macro_tiles, Lists out) {
  const std::uint32_t own = macro_tiles.order[blockIdx.x], size = macro_tiles.counts[own];
  const bool is_full = size >= MacroTiles::kUsual;
  if (is_full && macro_tiles.capacity > MacroTiles::kUsual) return;
  const unsigned listed = is_full || size > macro_tiles.capacity ? 0 : size;
  const SharedArrays arrays(dynamic_shared(), MacroTiles::kUsual);
  list_macro_tile<kUsualThreads>(own, listed, arrays, macro_tiles, out);
}

/// The others, which come first in the order; blocks take them in turns.
__global__ void __launch_bounds__(kFullThreads, kFullBlocks)
    list_full(MacroTiles macro_tiles, Lists out) {
  const auto count = static_cast<unsigned>(macro_tiles.count());
  for (unsigned place = blockIdx.x; place < count; place += gridDim.x) {
    const std::uint32_t own = macro_tiles.order[place], size = macro_tiles.counts[own];
    if (size < MacroTiles::kUsual) return;
    const SharedArrays arrays(dynamic_shared(), macro_tiles.capacity);
    list_macro_tile<kFullThreads>(own, size <= macro_tiles.capacity ? size : 0, arrays, macro_tiles,
                                  out);
  }
}

}  // namespace

std::uint32_t most_per_macro_tile() {
  constexpr std::size_t kStaticBytes = 36 << 10;  // of list_full, rounded up
  int device = 0, bytes = 0;
  check(cudaGetDevice(&device), "cudaGetDevice");
  check(cudaDeviceGetAttribute(&bytes, cudaDevAttrMaxSharedMemoryPerBlockOptin, device),
        "cudaDeviceGetAttribute");
  const std::size_t available = static_cast<std::size_t>(bytes) - kStaticBytes;
  const std::size_t most = available / SharedArrays::kBytesEach;
  return static_cast<std::uint32_t>(std::max<std::size_t>(most, MacroTiles::kUsual));
}

void list_by_macro_tile(const FrameContext& frame, const FrameSize& size, Scratch& scratch,
                        TilePairs& pairs, cudaStream_t full_stream) {
  const Lists out{frame.grid,          scratch.ranges,   pairs.gaussians.data(), size.pair_capacity,
                  scratch.class_sizes, scratch.schedule, scratch.segments};
  const MacroTiles& macro_tiles = scratch.macro_tiles;
  const auto count = static_cast<unsigned>(macro_tiles.count());
  const auto bytes_of = [](std::uint32_t capacity) { return SharedArrays::kBytesEach * capacity; };
  if (size.has_full_macro_tiles()) {
    launch("sort", list_full,
           Blocks(std::min(count, kFullCount), kFullThreads, bytes_of(size.macro_capacity)),
           full_stream, macro_tiles, out);
  }
  launch("sort", list_usual, Blocks(count, kUsualThreads, bytes_of(MacroTiles::kUsual)),
         frame.stream, macro_tiles, out);
}

}  // namespace qs::cuda::fast
