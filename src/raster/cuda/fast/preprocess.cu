// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cfloat>

#include <glm/geometric.hpp>

#include "raster/cuda/common/dynamic_shared.cuh"
#include "raster/cuda/common/schedule.cuh"
#include "raster/cuda/fast/append.cuh"
#include "raster/cuda/fast/segments.cuh"
#include "raster/cuda/fast/stages.cuh"
#include "raster/kernel/blend.h"
#include "raster/kernel/cull/modes.h"
#include "raster/kernel/sh.h"

namespace qs::cuda::fast {
namespace {

struct ProjectInput {
  CloudView cloud;
  View<float> view;
  FootprintRules rules;
  TileGrid grid;
  std::uint32_t nearest_bits;  // of the depth whose key is 0
  OcclusionView occlusion;
};

__device__ bool is_shown(const Frustum& frustum, const CloudView& cloud, unsigned block) {
  return cloud.draws_block(block) && !frustum.misses(cloud.bounds[block]);
}

/// Sets FastVisible::shown, a thread per block of Gaussians, and clears memory: 64-bit words.
__global__ void __launch_bounds__(kThreads)
    find_shown_blocks(Frustum frustum, CloudView cloud, unsigned blocks, std::uint8_t* shown,
                      std::uint64_t* to_clear, std::size_t words) {
  const unsigned thread = blockIdx.x * kThreads + threadIdx.x;
  for (std::size_t word = thread; word < words; word += std::size_t{gridDim.x} * kThreads)
    to_clear[word] = 0;
  if (thread < blocks) shown[thread] = is_shown(frustum, cloud, thread) ? 1 : 0;
}

__device__ std::uint32_t depth_key(float depth, std::uint32_t nearest_bits) {
  const std::uint32_t bits = __float_as_uint(depth);
  return bits > nearest_bits ? bits - nearest_bits : 0;
}

/// Sets FastVisible::shown of a frame with slabs, a thread per block of Gaussians, and counts the
/// depths of the shown blocks in the histogram.
__global__ void __launch_bounds__(kThreads)
    find_depths(Frustum frustum, CloudView cloud, unsigned blocks, std::uint8_t* shown,
                OcclusionView out, std::uint32_t nearest_bits) {
  const unsigned block = blockIdx.x * kThreads + threadIdx.x;
  if (block >= blocks) return;
  shown[block] = is_shown(frustum, cloud, block) ? 1 : 0;
  if (shown[block] == 0) return;
  const auto depths = frustum.depths(cloud.bounds[block]);
  const float2 range = {static_cast<float>(depths.x), static_cast<float>(depths.y)};
  out.depths[block] = range;
  const std::uint32_t key = depth_key(fmaxf(0.5f * (range.x + range.y), 0.0f), nearest_bits);
  atomicAdd(&out.histogram[min(key >> OcclusionView::kBinShift, OcclusionView::kBins - 1)], 1u);
}

constexpr unsigned kSlabThreads = 1024;

/// Finds the borders between slabs with about the same number of blocks. One block of threads.
__global__ void __launch_bounds__(kSlabThreads)
    find_slabs(OcclusionView out, unsigned slabs, FastCounters* counters) {
  constexpr unsigned kEach = OcclusionView::kBins / kSlabThreads;
  std::uint32_t own[kEach], sum = 0;
#pragma unroll
  for (unsigned k = 0; k < kEach; ++k) sum += own[k] = out.histogram[threadIdx.x * kEach + k];
  const BlockSum<std::uint32_t> all = sum_of_block<kSlabThreads>(sum);
  if (threadIdx.x == 0) counters->shown_blocks = all.total;
  const auto wanted_before = [&](unsigned slab) {
    return static_cast<std::uint32_t>(std::uint64_t{all.total} * slab / slabs);
  };
  if (threadIdx.x <= slabs) {
    const bool is_empty = threadIdx.x < slabs && wanted_before(threadIdx.x) == 0;
    out.borders[threadIdx.x] = is_empty ? 0 : kInvisibleKey;
  }
  __syncthreads();
  std::uint32_t before = all.before;
#pragma unroll
  for (unsigned k = 0; k < kEach; ++k) {
    const std::uint32_t end = before + own[k];
    for (unsigned s = 1; s < slabs; ++s) {
      const std::uint32_t wanted = wanted_before(s);
      if (before < wanted && wanted <= end)
        out.borders[s] = (threadIdx.x * kEach + k + 1) << OcclusionView::kBinShift;
    }
    before = end;
  }
}

constexpr std::uint8_t kInSlab = 2;  // FastVisible::shown of a frame with slabs

/// Finds the blocks with Gaussians in a slab, and clears memory.
__global__ void __launch_bounds__(kThreads)
    find_slab(Frustum frustum, View<float> view, const BlockBounds* bounds, unsigned blocks,
              std::uint8_t* shown, OcclusionView occlusion, std::uint32_t nearest_bits,
              std::uint64_t* to_clear, std::size_t words) {
  const unsigned block = blockIdx.x * kThreads + threadIdx.x;
  for (std::size_t word = block; word < words; word += std::size_t{gridDim.x} * kThreads)
    to_clear[word] = 0;
  if (block >= blocks || shown[block] == 0) return;
  const float2 depths = occlusion.depths[block];
  const std::uint32_t nearest = depth_key(fmaxf(depths.x, 0.0f), nearest_bits);
  const std::uint32_t farthest = depth_key(fmaxf(depths.y, 0.0f), nearest_bits);
  bool is_in = farthest >= occlusion.borders[occlusion.slab] &&
               nearest < occlusion.borders[occlusion.slab + 1];
  if (is_in && occlusion.slab > 0 && depths.x > view.near_depth) {
    const BlockBounds own = bounds[block];
    glm::vec2 low(INFINITY), high(-INFINITY);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec3 point((corner & 1) != 0 ? own.low.x : own.high.x,
                            (corner & 2) != 0 ? own.low.y : own.high.y,
                            (corner & 4) != 0 ? own.low.z : own.high.z);
      const glm::vec2 pixel = to_pixel(view, to_view(view, point));
      low = glm::min(low, pixel);
      high = glm::max(high, pixel);
    }
    const float reach = frustum.reach_px(own.sigma, depths.x);
    is_in = !occlusion.hides(PixelRect(0.5f * (low + high), 0.5f * (high - low) + reach,
                                       occlusion.width, occlusion.height));
  }
  shown[block] = is_in ? kInSlab : 1;
}

constexpr unsigned kProjectBlocks = 5;          // per multiprocessor, to hide latency
constexpr unsigned kProjectGrid = 4096;         // blocks that share the Gaussians, at most
constexpr unsigned kColorGrid = 16384;          // the same for `color`
constexpr unsigned kFindGrid = 16;              // blocks that clear memory, at least
constexpr std::uint32_t kStagedEntries = 1280;  // of a block; others are appended one by one
static_assert(kStagedEntries < BlockCounts::kMost);
constexpr int kLargeLines = 512;       // of a walk in shared memory; longer walks are recomputed
constexpr unsigned kAppendBlocks = 8;  // per multiprocessor, for the large Gaussians
constexpr unsigned kAppendThreads = 128;

/// The Gaussians of a block of threads and their entries of macro-tiles, in shared memory. All
/// threads of the block call each function together.
template <class P>
struct ProjectedBlock {
  Appended<P> appended[kThreads];
  std::uint32_t staged_count, staged[kStagedEntries];
  std::uint32_t spilled, next_spilled;  // entries of the block; place of the next entry

  static __device__ bool is_in_slab(const ProjectInput& in, std::uint32_t i) {
    const float4 position = in.cloud.positions[i];
    const float depth = to_view(in.view, glm::vec3(position.x, position.y, position.z)).z;
    return in.occlusion.holds(depth_key(fmaxf(depth, 0.0f), in.nearest_bits));
  }
  static __device__ bool is_hidden(const ProjectInput& in, const Footprint& footprint) {
    if (in.occlusion.slab == 0 || !(footprint.gamma > 0.0f)) return false;
    return in.occlusion.hides(PixelRect(footprint.mean_px, half_box_of(footprint),
                                        in.occlusion.width, in.occlusion.height));
  }

  /// Projects Gaussian `i`, the thread's own, and adds its tiles to *sampled_tiles, see CutRule.
  /// Returns true if it is visible.
  __device__ __forceinline__ bool project_own(const ProjectInput& in, const FastVisible& out,
                                              std::uint32_t i, std::uint32_t* large,
                                              FastCounters* counters,
                                              std::uint32_t* sampled_tiles) {
    Appended<P>& own = appended[threadIdx.x];
    own.clear();
    Projected projected;
    bool is_large = false;
    const bool is_projected = i < in.cloud.count && in.cloud.draws(i) &&
                              (!in.occlusion.is_used() || is_in_slab(in, i)) &&
                              project(in.view, in.rules, in.cloud.gaussian(i), projected) &&
                              (!in.occlusion.is_used() || !is_hidden(in, projected.footprint));
    if (is_projected) is_large = !own.set(projected.footprint, in.grid);
    if (is_projected && is_sampled(i / kWarp, kSampled) && projected.footprint.gamma > 0) {
      const TileRect box = bounds<AdrAabb>(projected.footprint, in.grid);
      atomicAdd(sampled_tiles, static_cast<std::uint32_t>(box.columns.size() * box.rows.size()));
    }
    const bool visible = is_large || own.has_walk();
    own.depth_key = visible ? depth_key(projected.depth, in.nearest_bits) : kInvisibleKey;
    if (i < in.cloud.count) out.depth_keys[i] = own.depth_key;
    if (visible) {
      const Footprint& footprint = projected.footprint;
      out.footprints[i] = {footprint.mean_px, footprint.covariance, footprint.gamma, {0, 0}};
    }
    const std::uint32_t slot = reserve_slot(is_large, &counters->large);
    if (is_large) large[slot] = i;
    return visible;
  }

  /// Stages the entries of all Gaussians and counts them. Entries that do not fit are appended at
  /// once.
  __device__ __forceinline__ void stage_entries(std::uint32_t first, const FastVisible& out,
                                                const MacroTiles& macro_tiles, TileGrid grid,
                                                const BlockCounts& counts) {
    const unsigned first_owner = threadIdx.x / kWarp * kWarp;
    for_each_macro_tile(
        appended + first_owner, first + first_owner, out, macro_tiles, grid,
        [&](bool exists, unsigned macro_tile, unsigned owner, unsigned tiles) {
          const std::uint32_t at = reserve_slot(exists, &staged_count);
          if (!exists) return;
          owner += first_owner;
          if (at < kStagedEntries) {
            const unsigned counter = counts.counter_of(macro_tile);
            staged[at] = StagedEntry(counter, owner, tiles).word;
            atomicAdd(&counts[counter], 1u);
          } else {
            macro_tiles.append(macro_tile, {appended[owner].depth_key, first + owner}, tiles);
          }
        });
  }

  /// Reserves room for the staged entries. The counts become the first slots in the macro-tiles.
  __device__ __forceinline__ void reserve_room(const MacroTiles& macro_tiles,
                                               const BlockCounts& counts) {
    for (unsigned c = threadIdx.x; c < counts.size(); c += kThreads) {
      const std::uint32_t here = counts[c];
      if (here == 0) continue;
      const std::uint32_t begin = atomicAdd(&macro_tiles.counts[counts.macro_tile_of(c)], here);
      const std::uint32_t end = begin + here;
      const std::uint32_t beyond = end - min(end, max(begin, macro_tiles.slicing.size.capacity));
      if (beyond > 0) atomicAdd(&spilled, beyond);
      counts[c] = begin;
    }
    __syncthreads();
    if (threadIdx.x == 0 && spilled > 0)
      next_spilled = atomicAdd(macro_tiles.slicing.part_count(Slicing::own_part()), spilled);
  }

  /// Stores the staged entries from the slots in `next` on.
  __device__ __forceinline__ void store_entries(std::uint32_t first, const MacroTiles& macro_tiles,
                                                const BlockCounts& next) {
    const std::uint32_t staged_here = min(staged_count, kStagedEntries);
    for (std::uint32_t s = threadIdx.x; s - lane_index() < staged_here; s += kThreads) {
      const bool exists = s < staged_here;
      const StagedEntry entry = exists ? StagedEntry(staged[s]) : StagedEntry::none();
      const unsigned counter = entry.counter(), owner = entry.owner();
      const std::uint32_t slot = reserve_slot_of(counter, exists, next.counts());
      const std::uint32_t place =
          reserve_slot(exists && slot >= macro_tiles.slicing.size.capacity, &next_spilled);
      if (!exists) continue;
      macro_tiles.store(next.macro_tile_of(counter), slot, place,
                        {appended[owner].depth_key, first + owner}, entry.mask());
    }
  }
};

/// Projects a block of Gaussians and appends them to macro-tiles. It counts their entries first,
/// and reserves room once per macro-tile and once for all spilled entries: thousands of atomic
/// additions to the same counter would take longer than all other work. All threads of a block call
/// it together.
template <class P>
__device__ void project_block(const ProjectInput& in, const FastVisible& out,
                              const MacroTiles& macro_tiles, std::uint32_t* large,
                              FastCounters* counters, std::uint32_t* sampled_tiles,
                              std::uint32_t block) {
  __shared__ ProjectedBlock<P> shared;
  const BlockCounts counts(dynamic_shared(), static_cast<unsigned>(macro_tiles.count()));
  const std::uint32_t first = block * kThreads;
  counts.clear();
  if (threadIdx.x == 0) shared.staged_count = shared.spilled = 0;

  const bool visible =
      shared.project_own(in, out, first + threadIdx.x, large, counters, sampled_tiles);
  const int visible_here = __syncthreads_count(visible);
  if (threadIdx.x == 0 && visible_here > 0) {
    atomicAdd(&counters->visible, static_cast<std::uint32_t>(visible_here));
    out.blocks[atomicAdd(&counters->visible_blocks, 1u)] = block;
  }
  shared.stage_entries(first, out, macro_tiles, in.grid, counts);
  __syncthreads();
  shared.reserve_room(macro_tiles, counts);
  __syncthreads();
  shared.store_entries(first, macro_tiles, counts);
  __syncthreads();
}

/// Blocks of threads share the blocks of Gaussians. First, one thread per block of Gaussians tests
/// whether the view may show it.
template <class P>
__global__ void __launch_bounds__(kThreads, blocks_at_once(kProjectBlocks, kThreads))
    project_and_append(ProjectInput in, FastVisible out, MacroTiles macro_tiles,
                       std::uint32_t* large, FastCounters* counters) {
  __shared__ std::uint32_t shown_count, shown[kThreads], sampled_tiles;
  if (threadIdx.x == 0) sampled_tiles = 0;
  __syncthreads();
  const std::uint32_t blocks = (in.cloud.count + kBlockGaussians - 1) / kBlockGaussians;
  std::uint32_t shown_here = 0;
  for (std::uint32_t first = blockIdx.x; first < blocks; first += gridDim.x * kThreads) {
    if (threadIdx.x == 0) shown_count = 0;
    __syncthreads();
    const std::uint32_t turn = first + threadIdx.x * gridDim.x;
    const std::uint8_t least = in.occlusion.is_used() ? kInSlab : 1;
    const bool is_shown = turn < blocks && out.shown[blocks - 1 - turn] >= least;
    const std::uint32_t slot = reserve_slot(is_shown, &shown_count);
    if (is_shown) shown[slot] = blocks - 1 - turn;
    __syncthreads();
    shown_here += shown_count;
    for (std::uint32_t k = 0; k < shown_count; ++k)
      project_block<P>(in, out, macro_tiles, large, counters, &sampled_tiles, shown[k]);
    __syncthreads();
  }
  if (threadIdx.x == 0 && shown_here > 0 && !in.occlusion.is_used())
    atomicAdd(&counters->shown_blocks, shown_here);
  if (threadIdx.x == 0 && sampled_tiles > 0)
    atomicAdd(reinterpret_cast<unsigned long long*>(&counters->sampled_tiles),
              static_cast<unsigned long long>(sampled_tiles));
}

/// Determines the number of slices of each full macro-tile, and numbers the slices. All threads of
/// one block call it together. The full macro-tiles are the first `count` in the order.
__device__ void number_slices(const MacroTiles& tiles, std::uint32_t count,
                              FastCounters* counters) {
  const std::uint32_t target = tiles.slicing.size.slice_target;
  const volatile std::uint32_t* const counts = tiles.counts;
  std::uint32_t sum = 0;
  for (std::uint32_t first = 0; first < count; first += kAppendThreads) {
    const std::uint32_t place = first + threadIdx.x;
    const std::uint32_t own = place < count ? tiles.order[place] : 0;
    const std::uint32_t slices = place < count ? (counts[own] + target - 1) / target : 0;
    const BlockSum<std::uint32_t> before = sum_of_block<kAppendThreads>(slices);
    if (place < count) tiles.slicing.slices[own] = {sum + before.before, slices};
    sum += before.total;
  }
  if (threadIdx.x == 0) counters->slices = sum;
}

/// Calls visit(exists, macro-tile, its Gaussians) for all macro-tiles; the Gaussians are 0 if the
/// macro-tile does not exist. All threads of one block call it together, and call visit() together.
/// One block reads the counts of a large picture, so a thread has several reads under way.
template <class Visit>
__device__ void for_each_count(const MacroTiles& tiles, const Visit& visit) {
  constexpr unsigned kEach = 8;
  const auto count = static_cast<unsigned>(tiles.count());
  for (unsigned first = 0; first < count; first += kEach * kAppendThreads) {
    std::uint32_t gaussians[kEach];
#pragma unroll
    for (unsigned k = 0; k < kEach; ++k) {
      const unsigned i = first + k * kAppendThreads + threadIdx.x;
      gaussians[k] = i < count ? load_fresh(&tiles.counts[i]) : 0;
    }
#pragma unroll
    for (unsigned k = 0; k < kEach; ++k) {
      if (first + k * kAppendThreads >= count) break;
      const unsigned i = first + k * kAppendThreads + threadIdx.x;
      visit(i < count, i, gaussians[k]);
    }
  }
}

/// Finds the order of the macro-tiles, and the counters that begin with the fullest one. All
/// threads of one block call it together.
__device__ void order_macro_tiles(const MacroTiles& tiles, FastCounters* counters) {
  __shared__ std::uint32_t begins[kLengthClasses];
  __shared__ std::uint32_t fullest, full, entries;
  const auto class_of = [](bool exists, std::uint32_t gaussians) {
    return exists ? length_class(gaussians) : kLengthClasses;
  };
  if (threadIdx.x < kLengthClasses) begins[threadIdx.x] = 0;
  if (threadIdx.x == 0) fullest = full = entries = 0;
  __syncthreads();
  std::uint32_t most = 0, full_here = 0, sum = 0;
  for_each_count(tiles, [&](bool exists, unsigned, std::uint32_t gaussians) {
    reserve_slot_of(class_of(exists, gaussians), exists, begins);
    most = max(most, gaussians);
    sum += gaussians;
    full_here += gaussians >= MacroTiles::kUsual ? 1 : 0;
  });
  atomicMax(&fullest, most);
  atomicAdd(&entries, sum);
  if (full_here > 0) atomicAdd(&full, full_here);
  __syncthreads();
  if (threadIdx.x < kWarp) {
    const std::uint32_t own = begins[threadIdx.x];
    begins[threadIdx.x] = inclusive_sum_of_warp(own) - own;
  }
  if (threadIdx.x == 0) {
    counters->entries = entries;
    counters->fullest_macro_tile = fullest;
    counters->full_macro_tiles = full;
  }
  __syncthreads();
  for_each_count(tiles, [&](bool exists, unsigned macro_tile, std::uint32_t gaussians) {
    const std::uint32_t place = reserve_slot_of(class_of(exists, gaussians), exists, begins);
    if (exists) tiles.order[place] = macro_tile;
  });
  __syncthreads();
  if (full > 0 && threadIdx.x < Slicing::kParts) {
    const volatile std::uint32_t* const spilled = tiles.slicing.part_count(threadIdx.x);
    atomicMax(&counters->spilled, *spilled);
  }
  if (tiles.slicing.size.has_slices()) number_slices(tiles, full, counters);
}

/// The macro-tiles that a large Gaussian may meet, and the lines of its walk, for the threads of a
/// warp or of a block. The threads call each function together.
template <class P>
struct LargeGaussian {
  TileGrid grid;
  Footprint footprint;
  Span lines{0, 0};
  bool by_rows = true;
  TileRect rect;

  __device__ LargeGaussian(const Footprint& from, TileGrid tiles) : grid(tiles), footprint(from) {
    TileRect all;
    if constexpr (kWalks<P>) {
      const auto walk = P::walk(footprint, grid);
      lines = walk.lines;
      by_rows = walk.by_rows;
      all = TileRect::of_lines(by_rows, lines, walk.widest());
    } else {
      all = bounds<P>(footprint, grid);
    }
    rect = macro_rect(all);
  }

  __device__ int count() const { return rect.columns.size() * rect.rows.size(); }

  /// Stores the runs of the lines, as far as there is room for `most`. The threads must wait for
  /// each other afterwards.
  __device__ void find_runs(Span* runs, int most, unsigned thread, unsigned threads) const {
    if constexpr (kWalks<P>) {
      const auto walk = P::walk(footprint, grid);
      const int last = min(lines.end, lines.begin + most);
      for (int line = lines.begin + static_cast<int>(thread); line < last;
           line += static_cast<int>(threads)) {
        runs[line - lines.begin] = walk.span(line);
      }
    }
  }

  __device__ void append(const Span* runs, int most, unsigned thread, unsigned threads,
                         SortEntry entry, const MacroTiles& macro_tiles) const {
    const int width = rect.columns.size();
    for (int i = static_cast<int>(thread); i < count(); i += static_cast<int>(threads)) {
      const int column = rect.columns.begin + i % width, row = rect.rows.begin + i / width;
      unsigned tiles = 0;
      if (kWalks<P> && lines.size() <= most) {
        MacroMask listed(column, row);
        listed.add_walk(by_rows, lines, [&](int line) { return runs[line - lines.begin]; });
        tiles = listed.mask;
      } else {
        tiles = tiles_in<P>(footprint, grid, column, row);
      }
      const auto macro_tile = static_cast<unsigned>(row * macro_tiles.columns + column);
      if (tiles != 0) macro_tiles.append(macro_tile, entry, tiles);
    }
  }
};

/// Appends large Gaussians to macro-tiles: with a warp each, or with a whole block if they meet
/// very many. The last block to end then orders the macro-tiles.
template <class P>
__global__ void __launch_bounds__(kAppendThreads)
    append_large(TileGrid grid, FastVisible visible, MacroTiles macro_tiles,
                 const std::uint32_t* large, FastCounters* counters) {
  constexpr unsigned kWarps = kAppendThreads / kWarp;
  constexpr int kWarpLines = 32, kWarpMacroTiles = 4 * kWarp;
  __shared__ Span runs[kLargeLines], runs_of_warps[kWarps][kWarpLines];
  __shared__ std::uint32_t huge[kWarps];  // places of Gaussians for the whole block
  constexpr std::uint32_t kNone = 0xffffffffu;
  const std::uint32_t count = counters->large;
  const unsigned warp = threadIdx.x / kWarp;
  for (std::uint32_t first = blockIdx.x; first < count; first += gridDim.x * kWarps) {
    const std::uint32_t l = first + warp * gridDim.x;
    std::uint32_t huge_here = kNone;
    if (l < count) {
      const std::uint32_t place = large[l];
      const LargeGaussian<P> own(visible.footprints[place].footprint(), grid);
      if (own.lines.size() <= kWarpLines && own.count() <= kWarpMacroTiles) {
        own.find_runs(runs_of_warps[warp], kWarpLines, lane_index(), kWarp);
        __syncwarp();
        own.append(runs_of_warps[warp], kWarpLines, lane_index(), kWarp,
                   {visible.depth_keys[place], place}, macro_tiles);
      } else {
        huge_here = place;
      }
    }
    if (lane_index() == 0) huge[warp] = huge_here;
    __syncthreads();
    for (const std::uint32_t place : huge) {
      if (place == kNone) continue;
      const LargeGaussian<P> own(visible.footprints[place].footprint(), grid);
      own.find_runs(runs, kLargeLines, threadIdx.x, kAppendThreads);
      __syncthreads();
      own.append(runs, kLargeLines, threadIdx.x, kAppendThreads, {visible.depth_keys[place], place},
                 macro_tiles);
      __syncthreads();
    }
    __syncthreads();
  }
  if (is_last_block(&counters->blocks_done)) order_macro_tiles(macro_tiles, counters);
}

/// BoundedSplat::clamp_rows.
__device__ float clamp_rows_of(const Footprint& footprint, float log2_opacity, float y_max) {
  constexpr float kLog2AlphaMax = -0.014499570f;
  constexpr float kRounding = 2e-5f;    // of log2 alpha, per thinness
  constexpr float kTolerance = 0.005f;  // of log2 alpha
  constexpr float kThinnest = 1e5f;     // the determinant is then known to 1 %
  // The ellipse alpha = 0.99 2^-kTolerance of an opaque Gaussian, relative to its ellipse alpha =
  // 1/255, and a margin. A solid ellipse has little beyond it.
  constexpr float kPart = 0.06f, kMarginPx = 0.1f;
  const float part = footprint.is_solid() ? 1.0f : kPart;
  const Covariance2<float>& covariance = footprint.covariance;
  const float thinness = covariance.xx * covariance.yy / footprint.determinant;  // >= 1
  if (!(thinness < kThinnest)) return INFINITY;
  const float rounding = kRounding * thinness;
  if (log2_opacity + fmaxf(rounding, kTolerance) < kLog2AlphaMax) return -1;
  return rounding < kTolerance ? fmaf(part, y_max, kMarginPx) : FLT_MAX;
}

__device__ BoundedSplat splat_of(const Footprint& footprint, glm::vec3 color) {
  constexpr float kGammaToLog2 = static_cast<float>(0.5 * kLog2E);
  const Splat splat = make_splat(footprint, 1.0f, color);
  const float log2_opacity = kGammaToLog2 * footprint.gamma - kLog2Of255;
  const AlphaEllipse ellipse = ellipse_of(footprint);
  return {splat.mean_px.x,
          splat.mean_px.y,
          splat.log2_conic.x,
          splat.log2_conic.y,
          splat.log2_conic.z,
          log2_opacity,
          clamp_rows_of(footprint, log2_opacity, ellipse.y_max),
          color.x,
          color.y,
          color.z,
          ellipse,
          0};
}

/// kHalves: the scene has CloudView::sh_halves.
template <bool kHalves>
__global__ void __launch_bounds__(kThreads, blocks_at_once(kHalves ? 6 : 8, kThreads))
    color_gaussians(CloudView cloud, glm::vec3 camera, int sh_degree, const FastCounters* counters,
                    FastVisible visible) {
  const std::uint32_t blocks = counters->visible_blocks;
  for (std::uint32_t b = blockIdx.x; b < blocks; b += gridDim.x) {
    const std::uint32_t i = visible.blocks[b] * kBlockGaussians + threadIdx.x;
    if (i >= cloud.count || visible.depth_keys[i] == kInvisibleKey) continue;
    const float4 position = cloud.positions[i];
    const glm::vec3 direction =
        glm::normalize(glm::vec3(position.x, position.y, position.z) - camera);
    const glm::vec3 color = sh_color<float>(sh_degree, direction, [&](int k) {
      if constexpr (kHalves) return cloud.coefficient_of_halves(i, k);
      return cloud.coefficient(i, k);
    });
    visible.splats[i] = splat_of(visible.footprints[i].footprint(), color);
  }
}

}  // namespace

void project(const FrameContext& frame, Scratch& scratch, const OcclusionView& occlusion,
             Event& footprints_known) {
  const CloudView cloud = frame.cloud.view();
  scratch.macro_tiles.entry_order = {cloud.file_indices};
  const View<float> view = make_view<float>(frame.camera);
  const unsigned blocks = blocks_for(cloud.count);
  with_culler(frame.settings.mode, [&]<class P>(P) {
    const FootprintRules rules = frame.rules();
    const Frustum frustum(view, rules, frame.grid);
    const std::uint32_t nearest = nearest_bits(frame.camera);
    if (!occlusion.is_used()) {
      launch("preprocess", find_shown_blocks, std::max(blocks_for(blocks), kFindGrid), frame.stream,
             frustum, cloud, blocks, scratch.visible.shown, scratch.to_clear.data(),
             scratch.to_clear.size());
    } else {
      if (occlusion.slab == 0) {
        set_zero("preprocess", scratch.to_clear.data(), scratch.to_clear.size(), frame.stream);
        launch("preprocess", find_depths, std::max(blocks_for(blocks), kFindGrid), frame.stream,
               frustum, cloud, blocks, scratch.visible.shown, occlusion, nearest);
        launch("preprocess", find_slabs, Blocks(1, kSlabThreads), frame.stream, occlusion,
               scratch.size.slabs, scratch.counters);
      }
      launch("preprocess", find_slab, std::max(blocks_for(blocks), kFindGrid), frame.stream,
             frustum, view, cloud.bounds, blocks, scratch.visible.shown, occlusion, nearest,
             scratch.to_clear_again.data(), scratch.to_clear_again.size());
    }
    const ProjectInput in{cloud, view, rules, frame.grid, nearest, occlusion};
    const Blocks with_counts(std::clamp(blocks, 1u, kProjectGrid), kThreads,
                             BlockCounts::bytes(scratch.size.macro_tiles()));
    launch("preprocess", project_and_append<P>, with_counts, frame.stream, in, scratch.visible,
           scratch.macro_tiles, scratch.large, scratch.counters);
    footprints_known.record(frame.stream);
    launch("preprocess", append_large<P>,
           Blocks(kAppendBlocks * scratch.multiprocessors, kAppendThreads), frame.stream,
           frame.grid, scratch.visible, scratch.macro_tiles, scratch.large, scratch.counters);
  });
}

void color(const FrameContext& frame, const Scratch& scratch, cudaStream_t stream) {
  const CloudView cloud = frame.cloud.view();
  launch("preprocess", cloud.sh_halves != nullptr ? color_gaussians<true> : color_gaussians<false>,
         std::clamp(blocks_for(cloud.count), 1u, kColorGrid), stream, cloud,
         make_view<float>(frame.camera).position, frame.sh_degree(), scratch.counters,
         scratch.visible);
}

}  // namespace qs::cuda::fast
