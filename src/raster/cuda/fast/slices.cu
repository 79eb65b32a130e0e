// SPDX-License-Identifier: MIT
//
// The kernels that list full macro-tiles:
//   find_slices    sorts the samples of every full macro-tile and chooses its cuts by depth
//   fill_slices    copies all its entries to the slices, in any order
//   count_slices   finds the samples in the slices, and counts entries and samples per tile
//   place_slices   reserves room for the lists
//   sort_slices    sorts every slice and writes its part of the lists
#include <algorithm>
#include <type_traits>

#include "raster/cuda/common/dynamic_shared.cuh"
#include "raster/cuda/fast/list_block.cuh"

namespace qs::cuda::fast {
namespace {

constexpr unsigned kBlocks =
    6;  // per multiprocessor, of the kernels that share the slices or entries
constexpr unsigned kPlaceThreads = MacroTiles::kTiles * kWarp;
constexpr unsigned kMovedEach = 12;  // entries that a thread moves at a time
constexpr std::uint32_t kMoved = kMovedEach * kThreads;
static_assert(kMoved >= MacroTiles::kUsual);
constexpr unsigned kMoveBlocks = 12 * Slicing::kParts;
constexpr std::uint32_t kCountedSlices = 8192;  // further slices are counted in global memory
static_assert(2 * kMoved <= kCountedSlices);

/// Blocks take full macro-tiles in turns. kGlobal: they sort in Slicing::sort_memory.
template <unsigned kBlock, bool kGlobal>
__global__ void __launch_bounds__(kBlock)
    find_slices(MacroTiles tiles, const FastCounters* counters) {
  const Slicing& slicing = tiles.slicing;
  const std::uint32_t capacity = slicing.size.sample_capacity;
  for (std::uint32_t place = blockIdx.x; place < counters->full_macro_tiles; place += gridDim.x) {
    const std::uint32_t own = tiles.order[place];
    const Slicing::Slices slices = slicing.slices[own];
    if (!slicing.holds(slices)) {
      // Later kernels find by the macro-tile that these slices are left out.
      const std::uint32_t end = min(slices.first + slices.count, slicing.size.slices);
      for (std::uint32_t s = slices.first + threadIdx.x; s < end; s += kBlock)
        slicing.macro_tile_of[s] = own;
      continue;
    }
    const std::uint32_t count = slicing.sample_count(tiles.counts[own]);
    const SortEntry* const samples = slicing.samples + std::size_t{own} * capacity;
    using Arrays = std::conditional_t<kGlobal, GlobalArrays, SharedArrays>;
    void* memory;
    if constexpr (kGlobal) {
      static_assert(Arrays::bytes(1) == Slicing::sort_bytes(1));
      memory = slicing.sort_memory + blockIdx.x * Arrays::bytes(capacity);
    } else {
      memory = dynamic_shared();
    }
    Arrays arrays(memory, capacity);
    BlockSort<kBlock, Arrays>(arrays, samples, tiles.entry_order, count).sort();
    __syncthreads();
    for (std::uint32_t s = threadIdx.x; s < slices.count; s += kBlock) {
      const auto sample = static_cast<unsigned>(std::uint64_t{s} * count / slices.count);
      const bool is_cut = s > 0 && count > 0;
      slicing.least_keys[slices.first + s] =
          is_cut ? tiles.entry_order.key(samples[arrays.order[sample]]) : 0;
      slicing.macro_tile_of[slices.first + s] = own;
      slicing.counts[slices.first + s] = 0;
    }
    __syncthreads();
  }
}

/// An entry of a full macro-tile that is copied to a slice. `mask`: its tiles.
struct Moved {
  SortEntry entry;
  std::uint32_t macro_tile, mask;
};

/// The slice of an entry; kNoSlice: the memory has no room for the slices of its macro-tile.
constexpr std::uint32_t kNoSlice = 0xffffffffu;

/// Finds the slices of the entries of a thread, in lockstep, so that their reads are under way at
/// the same time. `depths` is a copy of the depths in Slicing::least_keys, or null.
__device__ void find_slices_of(const MacroTiles& tiles, const std::uint32_t* depths,
                               const Moved (&moved)[kMovedEach],
                               std::uint32_t (&chosen)[kMovedEach]) {
  const Slicing& slicing = tiles.slicing;
  std::uint32_t counts[kMovedEach];  // of slices, from the chosen one on, that may be the entry's
#pragma unroll
  for (unsigned k = 0; k < kMovedEach; ++k) {
    counts[k] = 0;
    chosen[k] = kNoSlice;
    if (moved[k].mask == 0) continue;
    const Slicing::Slices slices = slicing.slices[moved[k].macro_tile];
    if (!slicing.holds(slices)) continue;
    chosen[k] = slices.first;
    counts[k] = slices.count;
  }
  // The file index decides only between entries of one depth.
  const auto begins_in_front_of = [&](std::uint32_t slice, SortEntry entry) {
    const std::uint32_t depth = depths != nullptr
                                    ? depths[slice]
                                    : static_cast<std::uint32_t>(slicing.least_keys[slice] >> 32);
    if (depth != entry.depth_key) return depth < entry.depth_key;
    return slicing.least_keys[slice] <= tiles.entry_order.key(entry);
  };
  for (bool goes_on = true; goes_on;) {
    goes_on = false;
#pragma unroll
    for (unsigned k = 0; k < kMovedEach; ++k) {
      if (counts[k] <= 1) continue;
      const std::uint32_t half = counts[k] / 2;
      if (begins_in_front_of(chosen[k] + half, moved[k].entry)) chosen[k] += half;
      counts[k] -= half;
      goes_on = goes_on || counts[k] > 1;
    }
  }
}

/// Copies entries to their slices; entry_at(i) returns entry i of `count`. A block counts first, so
/// that it reserves room once per slice. All its threads call it together. `shared` has room for
/// two numbers per slice, and for kCountedSlices numbers at most.
template <class EntryAt>
__device__ void move_entries(const MacroTiles& tiles, std::uint32_t* shared, std::uint32_t slices,
                             std::uint32_t count, const EntryAt& entry_at) {
  const Slicing& slicing = tiles.slicing;
  const bool counts_here = slices <= kCountedSlices;
  const bool has_depths = slices <= kMoved;  // else copying them takes longer than reading some
  std::uint32_t *const counts = shared, *const depths = shared + slices;
  Moved moved[kMovedEach];
  std::uint32_t chosen[kMovedEach], slots[kMovedEach];
#pragma unroll
  for (unsigned k = 0; k < kMovedEach; ++k) {
    const std::uint32_t i = k * kThreads + threadIdx.x;
    moved[k] = i < count ? entry_at(i) : Moved{};
  }
  for (std::uint32_t s = threadIdx.x; s < slices && counts_here; s += kThreads) {
    counts[s] = 0;
    if (has_depths) depths[s] = static_cast<std::uint32_t>(slicing.least_keys[s] >> 32);
  }
  __syncthreads();
  find_slices_of(tiles, has_depths ? depths : nullptr, moved, chosen);
#pragma unroll
  for (unsigned k = 0; k < kMovedEach; ++k) {
    std::uint32_t* const places = counts_here ? counts : slicing.counts;
    slots[k] = chosen[k] == kNoSlice ? 0 : atomicAdd(&places[chosen[k]], 1u);
  }
  __syncthreads();
  for (std::uint32_t s = threadIdx.x; s < slices && counts_here; s += kThreads)
    if (counts[s] > 0) counts[s] = atomicAdd(&slicing.counts[s], counts[s]);
  __syncthreads();
#pragma unroll
  for (unsigned k = 0; k < kMovedEach; ++k) {
    if (chosen[k] == kNoSlice) continue;
    const std::uint32_t slot = slots[k] + (counts_here ? counts[chosen[k]] : 0);
    if (slot >= slicing.size.slice_capacity) continue;
    const std::size_t at = std::size_t{chosen[k]} * slicing.size.slice_capacity + slot;
    slicing.entries[at] = moved[k].entry;
    slicing.masks[at] = static_cast<MarkedTiles>(moved[k].mask);
  }
  __syncthreads();
}

/// Blocks take full macro-tiles in turns and copy their entries, and chunks of spilled entries. The
/// first blocks have chunks in every frame, so the last ones begin with macro-tiles.
__global__ void __launch_bounds__(kThreads, blocks_at_once(3, kThreads))
    fill_slices(MacroTiles tiles, const FastCounters* counters) {
  auto* const shared = static_cast<std::uint32_t*>(dynamic_shared());
  const Slicing& slicing = tiles.slicing;
  const std::uint32_t slices = min(counters->slices, slicing.size.slices);
  for (std::uint32_t place = gridDim.x - 1 - blockIdx.x; place < counters->full_macro_tiles;
       place += gridDim.x) {
    const std::uint32_t own = tiles.order[place];
    const std::size_t first = std::size_t{own} * MacroTiles::kUsual;
    move_entries(tiles, shared, slices, MacroTiles::kUsual, [&](std::uint32_t i) {
      return Moved{tiles.entries[first + i], own, tiles.masks[first + i]};
    });
  }
  const std::uint32_t part = blockIdx.x % Slicing::kParts;
  const std::uint32_t spilled = min(*slicing.part_count(part), slicing.size.spilled);
  const std::uint32_t stride = gridDim.x / Slicing::kParts * kMoved;
  for (std::uint32_t chunk = blockIdx.x / Slicing::kParts * kMoved; chunk < spilled;
       chunk += stride) {
    const std::size_t first = std::size_t{part} * slicing.size.spilled + chunk;
    move_entries(tiles, shared, slices, min(spilled - chunk, kMoved), [&](std::uint32_t i) {
      const std::uint32_t where = slicing.spilled_tiles[first + i];
      return Moved{slicing.spilled[first + i], where >> 8, where & 255};
    });
  }
}

/// Blocks take slices in turns.
__global__ void __launch_bounds__(kThreads)
    count_slices(MacroTiles tiles, Lists out, const FastCounters* counters) {
  constexpr unsigned kTiles = MacroTiles::kTiles, kWarps = kThreads / kWarp;
  constexpr std::uint32_t kMostFound = 4096;  // of the largest slices
  __shared__ std::uint32_t of_warps[kWarps][2 * kTiles], found;
  __shared__ std::uint16_t samples[kMostFound];
  const Slicing& slicing = tiles.slicing;
  const CutRule rule = CutRule::of(out.segments);
  const std::uint32_t slices = min(counters->slices, slicing.size.slices);
  for (std::uint32_t slice = blockIdx.x; slice < slices; slice += gridDim.x) {
    const std::uint32_t macro_tile = slicing.macro_tile_of[slice];
    if (!slicing.holds(slicing.slices[macro_tile])) continue;
    const std::size_t first = std::size_t{slice} * slicing.size.slice_capacity;
    const std::uint32_t size = min(slicing.counts[slice], slicing.size.slice_capacity);
    const bool may_cut = out.segments.finds_samples && rule.may_cut(tiles.counts[macro_tile]);
    const TileRect window = tiles_of(tiles, macro_tile, out.grid);
    PackedCounts counts;
    if (threadIdx.x == 0) found = 0;
    __syncthreads();
#pragma unroll 4
    for (std::uint32_t i = threadIdx.x; i - lane_index() < size; i += kThreads) {
      const bool exists = i < size;
      if (exists) counts.add(slicing.masks[first + i]);
      if (!may_cut) continue;
      const bool may_be = exists && rule.may_be_sample(slicing.entries[first + i].place);
      const std::uint32_t slot = reserve_slot(may_be, &found);
      if (may_be && slot < kMostFound) samples[slot] = static_cast<std::uint16_t>(i);
    }
    __syncthreads();
    for (std::uint32_t k = threadIdx.x; k < min(found, kMostFound); k += kThreads) {
      const std::size_t at = first + samples[k];
      const MarkedTiles mask = slicing.masks[at];
      const MarkedTiles marked = out.samples.marked(slicing.entries[at].place, mask, window);
      slicing.masks[at] = marked;
      counts.add(marked & ~mask);
    }
#pragma unroll
    for (unsigned i = 0; i < 2 * kTiles; ++i) {
      const std::uint32_t sum = inclusive_sum_of_warp(counts.count(i));
      if (lane_index() == kWarp - 1) of_warps[threadIdx.x / kWarp][i] = sum;
    }
    __syncthreads();
    if (threadIdx.x < 2 * kTiles) {
      std::uint32_t sum = 0;
      for (unsigned w = 0; w < kWarps; ++w) sum += of_warps[w][threadIdx.x];
      const std::uint32_t place = slice * kTiles + threadIdx.x % kTiles;
      if (threadIdx.x < kTiles)
        slicing.list_begins[place] = sum;
      else
        slicing.sample_begins[place] = sum;
    }
    __syncthreads();
  }
}

/// Blocks take full macro-tiles in turns, and their warps a tile each.
__global__ void __launch_bounds__(kPlaceThreads)
    place_slices(MacroTiles tiles, Lists out, FastCounters* counters) {
  constexpr unsigned kTiles = MacroTiles::kTiles;
  __shared__ std::uint64_t begins[kTiles];
  const Slicing& slicing = tiles.slicing;
  const unsigned tile = threadIdx.x / kWarp, lane = lane_index();
  for (std::uint32_t place = blockIdx.x; place < counters->full_macro_tiles; place += gridDim.x) {
    const std::uint32_t own = tiles.order[place];
    Slicing::Slices slices = slicing.slices[own];
    if (!slicing.holds(slices)) slices.count = 0;
    const auto begin_of = [&](std::uint32_t s) -> std::uint64_t& {
      return slicing.list_begins[(slices.first + s) * kTiles + tile];
    };
    const auto samples_of = [&](std::uint32_t s) -> std::uint32_t& {
      return slicing.sample_begins[(slices.first + s) * kTiles + tile];
    };
    std::uint32_t length = 0, samples = 0, fullest = 0;
    for (std::uint32_t s = lane; s < slices.count; s += kWarp) {
      length += static_cast<std::uint32_t>(begin_of(s));
      samples += samples_of(s);
      fullest = max(fullest, slicing.counts[slices.first + s]);
    }
    length = inclusive_sum_of_warp(length);
    samples = inclusive_sum_of_warp(samples);
    length = __shfl_sync(kAllLanes, length, kWarp - 1);
    samples = __shfl_sync(kAllLanes, samples, kWarp - 1);
    if (lane == 0) begins[tile] = length;
    fullest = largest_of_warp(fullest);
    if (threadIdx.x == 0 && fullest > 0) atomicMax(&counters->fullest_slice, fullest);
    __syncthreads();
    if (tile == 0) {
      const auto whole = lane < kTiles ? static_cast<std::uint32_t>(begins[lane]) : 0u;
      const std::uint64_t begin = place_list(out, tiles_of(tiles, own, out.grid), whole);
      if (lane < kTiles) begins[lane] = begin;
    }
    __syncthreads();
    std::uint64_t begin = begins[tile];
    cut_list(out, tiles_of(tiles, own, out.grid), tile, begin, length, samples);
    std::uint32_t samples_before = 0;
    for (std::uint32_t first = 0; first < slices.count; first += kWarp) {
      const std::uint32_t s = first + lane;
      const std::uint64_t mine = s < slices.count ? begin_of(s) : 0;
      const std::uint64_t end = begin + inclusive_sum_of_warp(mine);
      const std::uint32_t own_samples = s < slices.count ? samples_of(s) : 0;
      const std::uint32_t samples_end = samples_before + inclusive_sum_of_warp(own_samples);
      if (s < slices.count) {
        begin_of(s) = end - mine;
        samples_of(s) = samples_end - own_samples;
      }
      begin = __shfl_sync(kAllLanes, end, kWarp - 1);
      samples_before = __shfl_sync(kAllLanes, samples_end, kWarp - 1);
    }
    __syncthreads();
  }
}

/// Blocks take slices in turns.
template <unsigned kBlock, unsigned kResident>
__global__ void __launch_bounds__(kBlock, blocks_at_once(kResident, kBlock))
    sort_slices(MacroTiles tiles, Lists out, const FastCounters* counters) {
  using Block = ListBlock<kBlock>;
  __shared__ typename Block::Shared shared;
  const Slicing& slicing = tiles.slicing;
  const std::uint32_t capacity = slicing.size.slice_capacity;
  const std::uint32_t count = min(counters->slices, slicing.size.slices);
  for (std::uint32_t slice = blockIdx.x; slice < count; slice += gridDim.x) {
    if (!slicing.holds(slicing.slices[slicing.macro_tile_of[slice]])) continue;
    const std::size_t first = std::size_t{slice} * capacity;
    Block block(SharedArrays(dynamic_shared(), capacity), shared,
                min(slicing.counts[slice], capacity));
    block.sort(slicing.entries + first, slicing.masks + first, tiles.entry_order);
    block.count();
    if (out.segments.finds_samples) block.count_samples();
    if (threadIdx.x < Block::kTiles) {
      const std::uint32_t own = slice * Block::kTiles + threadIdx.x;
      shared.begins[threadIdx.x] = slicing.list_begins[own];
      shared.sample_begins[threadIdx.x] = slicing.sample_begins[own];
    }
    __syncthreads();
    block.write(out, tiles_of(tiles, slicing.macro_tile_of[slice], out.grid),
                out.segments.finds_samples);
  }
}

}  // namespace

void list_sliced(const Scratch& scratch, cudaStream_t stream) {
  const Lists out = Lists::of(scratch);
  const MacroTiles& tiles = scratch.macro_tiles;
  const MacroSize& size = scratch.size.macro;
  FastCounters* const counters = scratch.counters;
  const unsigned blocks = kBlocks * scratch.multiprocessors;
  const auto launch_for = [&](std::uint32_t capacity, auto kernel, unsigned threads,
                              auto... arguments) {
    launch("sort", kernel, Blocks(blocks, threads, SharedArrays::bytes(capacity)), stream,
           arguments...);
  };
  if (size.sorts_in_global_memory) {
    launch("sort", find_slices<kLargeThreads, true>, Blocks(Slicing::kGlobalSorts, kLargeThreads),
           stream, tiles, counters);
  } else {
    const bool is_usual = size.sample_capacity <= MacroSize::kUsual;
    launch_for(size.sample_capacity,
               is_usual ? find_slices<kUsualThreads, false> : find_slices<kLargeThreads, false>,
               is_usual ? kUsualThreads : kLargeThreads, tiles, counters);
  }
  const std::size_t counted = std::min(kCountedSlices, 2 * size.slices) * sizeof(std::uint32_t);
  launch("sort", fill_slices, Blocks(kMoveBlocks, kThreads, counted), stream, tiles, counters);
  launch("sort", count_slices, blocks, stream, tiles, out, counters);
  launch("sort", place_slices,
         Blocks(std::min(blocks, static_cast<unsigned>(tiles.count())), kPlaceThreads), stream,
         tiles, out, counters);
  const std::uint32_t capacity = size.slice_capacity;
  const bool is_usual = capacity <= MacroSize::kUsual;
  launch_for(capacity,
             is_usual ? sort_slices<kUsualThreads, kUsualBlocks>
                      : sort_slices<kLargeThreads, kMediumBlocks>,
             is_usual ? kUsualThreads : kLargeThreads, tiles, out, counters);
}

}  // namespace qs::cuda::fast
